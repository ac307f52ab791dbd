"""What a program comes to: a value for each thing asked, how probable it is, what it rests on."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, field, replace
from statistics import NormalDist

import numpy as np

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.figures import rounded, rounded_up
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import travel_scale
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE, TOLERANCES
from geotlm_lm.core.twist import COMPONENT_OF, Component
from geotlm_lm.motion.belief import SPAN_DEVIATIONS, Belief
from geotlm_lm.query.program import AXIS, COMPONENT, WAY_ATOMS, Expression
from geotlm_lm.track.events import EventKind

BASES = {Component.TURN: "deg", Component.SLIDE: "px", Component.PRESS: "mm"}
"""What a component is measured in."""

LEAST_TIMED = 3
"""Different frames that a speed needs."""


@dataclass(frozen=True)
class Recording:
    """Facts about the file that the clip is of.

    Args:
        columns: Width of the recording's frames, pixels.
        rows: Their height.
        rate_hz: Frames per second, as stated or as the file tells; None where neither does.
        frames: How many the file has, however many of them were read.
        duration_s: How long it is; None where they are taken evenly at that rate, or nothing tells.
        is_uneven: Whether its frames were taken at uneven times, which each tells.
        used: Numbers of the frames that the clip is of.
        step_s: Time from frame to frame, or 1 for numbers of frames in its place.
    """

    columns: int = 224
    rows: int = 224
    rate_hz: float | None = None
    frames: int = 4
    used: tuple[int, ...] = (0, 1, 2, 3)
    step_s: float | None = None
    duration_s: float | None = None
    is_uneven: bool = False

    def at_rate(self, rate_hz: float | None, *, overrides: bool = True) -> Recording:
        """Return this at a stated rate; uneven times, and those of a track, stay what they are.

        Args:
            rate_hz: Stated; None for what the file tells.
            overrides: Whether it stands before what the file tells.
        """
        is_kept = self.is_uneven or not overrides
        if rate_hz is None or self.step_s is not None or (is_kept and self.rate_hz is not None):
            return self
        return replace(self, rate_hz=rate_hz, duration_s=None)

    @property
    def decimals(self) -> int:
        """With how many a time in seconds is told, so that no frame has that of another."""
        step_s = self.step_s or 1 / (self.rate_hz or 1.0)
        return max(1, math.ceil(-math.log10(step_s) - 1e-9))

    @property
    def seconds(self) -> float | None:
        """How long what moves does so: from the first used frame to the last.

        Two frames alone give no time: they may be any two of a longer motion.
        """
        is_timed = bool(self.rate_hz) and len(set(self.used)) >= LEAST_TIMED
        return (self.used[-1] - self.used[0]) / self.rate_hz if is_timed else None


@dataclass(frozen=True)
class Measure:
    """An amount as it is told.

    Args:
        atom: What it is of, an atom of the query.
        mean: Its value, in `unit`.
        deviation: Of it.
        unit: One of `UNITS`, "deg/s" and so on of a mean speed.
        tolerance: Least error that still counts as right.
    """

    atom: str
    mean: float
    deviation: float
    unit: str
    tolerance: float
    decimals: int | None = None
    is_padded: bool = False  # all decimals are written
    is_signed: bool = False  # a difference, which may be below zero

    @property
    def value(self) -> float:
        """What is told: no finer than the tolerance, to a digit at least, as `rounded`."""
        if self.decimals is not None:
            return round(self.mean, self.decimals)
        step = 10.0 ** math.floor(math.log10(max(self.tolerance, 1e-9)))
        value = round(self.mean / step) * step
        return rounded(value) if value else float(f"{self.mean:.1g}")

    @property
    def span(self) -> tuple[float, float]:
        """The ends between which it lies nine times in ten, rounded outwards; holds the value."""
        far = SPAN_DEVIATIONS * self.deviation
        is_signed = self.is_signed or self.atom in WAY_ATOMS
        low = self.mean - far if is_signed else max(self.mean - far, 0.0)
        low, high = 0.0 - rounded_up(-low), rounded_up(self.mean + far)
        return min(low, self.value), max(high, self.value)

    @property
    def limit(self) -> float:
        """Its value as a detection limit: rounded up."""
        return rounded_up(self.mean)

    def is_near(self, other: Measure) -> bool:
        """Tell whether both tell the same, within the tolerance."""
        far = max(self.tolerance, other.tolerance)
        return self.unit == other.unit and abs(self.value - other.value) <= far

    def to_dict(self) -> dict[str, float | str]:
        """Return plain JSON values."""
        low, high = self.span
        return {"value": self.value, "unit": self.unit, "low": low, "high": high}

    @property
    def word(self) -> str:
        """The amount as a program reads it: "15 deg"."""
        return f"{self.figure} {self.unit}"

    @property
    def figure(self) -> str:
        """Its value without a power of ten."""
        return f"{self.value:.{self.decimals}f}" if self.is_padded else f"{self.value:.10g}"

    @property
    def probability(self) -> float:
        """That the value is right within the tolerance, or a fifth of the true amount."""
        size = abs(self.value)
        low = min(size - self.tolerance, size / (1 + RELATIVE_TOLERANCE))
        high = max(size + self.tolerance, size / (1 - RELATIVE_TOLERANCE))
        bell = NormalDist(math.copysign(1, self.value) * self.mean, max(self.deviation, 1e-9))
        return bell.cdf(high) - bell.cdf(low)


def measure(
    atom: str,
    belief: Belief,
    frame: FrameSpec,
    recording: Recording,
    unit: str | None = None,
) -> Measure:
    """Return how far an atom goes.

    Args:
        atom: What goes, a key of `program.COMPONENT`: with a sign where it is a way.
        belief: What is believed.
        frame: Tells the size of a pixel, if anybody does.
        recording: The file.
        unit: "deg", "px" or "mm"; None for the usual one.
    """
    axis, scale, base = np.array(_axis(atom, belief)), 1.0, BASES[COMPONENT[atom]]
    mean = float(axis @ astuple(belief.mean))
    deviation = math.sqrt(max(float(axis @ belief.covariance @ axis), 0.0))
    if base == "px":  # how many pixels of the recording, or mm, are a pixel of our square
        unit = unit or ("px" if frame.mm_per_px is None else "mm")
        size = None if unit == "px" else frame.mm_per_px
        across, along = travel_scale(recording.rows, recording.columns, size)[1]
        scale = math.hypot(across * axis[1], along * axis[2])
    mean = mean if atom in AXIS else abs(mean)
    return Measure(atom, mean * scale, deviation * scale, unit or base, TOLERANCES[base] * scale)


def _axis(atom: str, belief: Belief) -> tuple[float, ...]:
    """Return along what an atom is measured: of a slide along the way that it goes."""
    _, right, down, _ = astuple(belief.mean)
    travel = math.hypot(right, down)
    if atom == "slide" and travel > 0:
        return (0.0, right / travel, down / travel, 0.0)
    ways = {"turn": "cw", "slide": "right", "x": "right", "y": "down", "press": "in"}
    return AXIS[ways.get(atom, atom)]


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
    aslant: Motion | None = None  # the lesser way of a slide between two
    is_diagonal: bool = False  # whether it goes nearly as far that way


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
    is_diagonal: bool = False  # whether it goes nearly as far the lesser way

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
    at_s: float | None = None  # the moment that the reason names
    lacking: Expression | None = None  # what happens that there is none of
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
    is_brief: bool = False  # whether the rest is of a span alone: something touches at other times
    # Of what does not move how far it would have to go to be seen.
    limits: tuple[tuple[Component, tuple[Measure, ...]], ...] = ()
    tightens: bool | None = None

    @property
    def ways(self) -> list[Motion]:
        """Where what moves goes."""
        return [move.way for move in self.movements]


@dataclass(frozen=True, kw_only=True)
class Choice(Value):
    """Which of some answers offered hold, or do not."""

    chosen: tuple[int, ...]  # places of the options
    chances: tuple[float, ...]  # of each
    motion: Moved | None = None
    each: tuple[Value, ...] = ()  # of two clips that are compared
    times_s: tuple[float, ...] = ()  # of what comes neither before nor after the other


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
