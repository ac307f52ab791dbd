"""What a program comes to: a value for each thing asked, how probable it is, what it rests on."""

from __future__ import annotations

from dataclasses import dataclass, field

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, Component
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.program import Expression
from geotlm_lm.track.events import EventKind


@dataclass(frozen=True)
class Shown:
    """A motion, a touch or a rest of a recording that an answer rests on."""

    kind: EventKind
    way: Motion
    begin_s: float
    end_s: float
    amount: Measure | None
    path_px: float
    probability: float
    is_edge: bool = True  # a press or release that is the beginning or the end of a contact


@dataclass(frozen=True)
class Movement:
    """One component as it is told."""

    way: Motion  # where it goes, of a slide the nearest of four ways
    aslant: Motion | None  # the lesser way of a slide between two
    amount: Measure | None  # how far; None where the picture does not tell
    chance: float  # that it moves and goes that way
    barely: bool
    times: tuple[float, float] | None = None  # from when to when, seconds; None of a clip
    path: Measure | None = None  # there and back, where that is well above the net one

    @property
    def component(self) -> Component:
        """What moves."""
        return COMPONENT_OF[self.way]


@dataclass(frozen=True, kw_only=True)
class Value:
    """What an expression comes to."""

    of: Expression
    probability: float = 1.0  # that it is right
    edit: Edit = field(default_factory=Edit)  # the whole point of view, from the recorded image
    shown: tuple[Shown, ...] = ()  # what it rests on
    clip: str | None = None  # "first" or "second" of two

    @property
    def is_known(self) -> bool:
        """Whether it could be told at all."""
        return True

    @property
    def moved(self) -> Moved | None:
        """The motion that it is, or rests on."""
        return self if isinstance(self, Moved) else getattr(self, "motion", None)


@dataclass(frozen=True, kw_only=True)
class Unknown(Value):
    """It cannot be told, and why: a name of `replies.toml`."""

    reason: str
    detail: str = ""  # what is told besides
    supposing: Value | None = None  # what it comes to on an ordinary thread seen from its head
    probability: float = 0.0

    @property
    def is_known(self) -> bool:
        """False: it could not be told."""
        return False


@dataclass(frozen=True, kw_only=True)
class Truth(Value):
    """Yes or no, and the motion or the amounts that it rests on."""

    holds: bool
    chance: float  # that it holds
    motion: Moved | None = None
    amounts: tuple[Amount, ...] = ()  # that are compared
    times_s: tuple[float, ...] = ()  # of what happens, or is put in order
    each: tuple[Value, ...] = ()  # of two clips that are compared


@dataclass(frozen=True, kw_only=True)
class Amount(Value):
    """A number with its unit and span."""

    amount: Measure
    motion: Moved | None = None
    at_s: float | None = None  # when, of a greatest one or of what comes back
    both: tuple[Measure, ...] = ()  # that way and the other, of what goes both


@dataclass(frozen=True, kw_only=True)
class Times(Value):
    """Moments of a recording, seconds; none where nothing of that happens."""

    times_s: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Moved(Value):
    """What moves, what of the asked does not, or what is so instead."""

    movements: tuple[Movement, ...] = ()
    denied: tuple[Component, ...] = ()
    still_axis: str | None = None  # of a slide that is asked about along "x" or "y"
    rest: Motion | None = None
    # Of what does not move how far it would have to go to be seen.
    limits: tuple[tuple[Component, tuple[Measure, ...]], ...] = ()
    tightens: bool | None = None


@dataclass(frozen=True, kw_only=True)
class Choice(Value):
    """Which of some answers offered hold, or do not."""

    chosen: tuple[int, ...]  # places of the options
    chances: tuple[float, ...]  # of each
    motion: Moved | None = None
    each: tuple[Value, ...] = ()  # of two clips that are compared


@dataclass(frozen=True, kw_only=True)
class Record(Value):
    """Several values under keys, or a list of them."""

    fields: tuple[tuple[str | None, Value], ...]


@dataclass(frozen=True, kw_only=True)
class Placed(Value):
    """Where the middle of the contact lies, as shares of the image, and how much is covered."""

    across: float
    down: float
    share: float


@dataclass(frozen=True, kw_only=True)
class Remark(Value):
    """Something told of the file, the set-up, the answer before, or of no motion at all."""

    kind: str
    topic: str | None = None
    recording: Recording | None = None  # that a fact about a file is of
