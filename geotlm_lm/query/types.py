"""What a question means, as plain values: asks, the point of view, facts stated on the way.

A number is never spelled: it is the k-th quantity of the question (`Slot`) until `filled`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.edit import Edit

WAY_ATOMS = {
    "cw": Motion.CLOCKWISE,
    "ccw": Motion.COUNTERCLOCKWISE,
    "left": Motion.LEFT,
    "right": Motion.RIGHT,
    "up": Motion.UP,
    "down": Motion.DOWN,
    "in": Motion.PRESS,
    "out": Motion.RELEASE,
}
COMPONENT_ATOMS = {"turn": Component.TURN, "slide": Component.SLIDE, "press": Component.PRESS}
STATE_ATOMS = ("move", "still", "touch", "none")
"""Anything moves; it touches and does not move; something touches; nothing touches."""

AXIS_ATOMS = ("x", "y", "xy")
"""Travel along the columns, along the rows; of amounts each of both."""

THREAD_ATOMS = ("tighten", "loosen")
EVENT_ATOMS = ("starts", "stops", "reverses", "speeds", "slows", "made", "lost")
"""What only a whole recording shows: "made" and "lost" are of contact."""

OTHER_ATOMS = ("other", "unknown")
"""Options such as "none of these" and "cannot tell"."""

ATOMS = (*WAY_ATOMS, *COMPONENT_ATOMS, *STATE_ATOMS, *AXIS_ATOMS[:2], *THREAD_ATOMS, *EVENT_ATOMS)
"""What a claim may be about."""

ASKED_ATOMS = (*COMPONENT_ATOMS, "x", "y", "thread", "sign")
"""What "which way" may be about; "sign" is of the turn."""

MEASURED_ATOMS = (*COMPONENT_ATOMS, *WAY_ATOMS, *AXIS_ATOMS, "touch")
"""What "how much" may be of; of "touch" the share of the image."""

UNITS = {
    "angle": ("deg", "rad", "turn", "arcmin"),
    "length": ("px", "mm", "cm", "um", "inch"),
    "time": ("s", "ms", "min", "frame"),
    "share": ("percent",),
}
PER = {"per-s": 1.0, "per-min": 60.0, "per-frame": None}
"""Times that an amount may be told per, in seconds; a frame's follows from the recording."""

UNANSWERABLE = (
    "force",
    "identity",
    "material",
    "look",
    "size",
    "quality",
    "temperature",
    "sound",
    "future",
    "advice",
    "cause",
    "place",
    "tilt",
    "axis",
    "world",
    "language",
    "off-topic",
)
"""What is asked that touch, or this program, cannot tell."""

TALK = ("greeting", "thanks", "fine", "bye", "doubt", "who")
TOPICS = ("duration", "frames", "rate", "interval", "size", "used", "scale")
SETTINGS = ("frame", "mirrored", "turned", "mover", "thread", "side", "options")
FORMS = ("sentence", "word", "letter", "number", "sign", "yes-no", "json", "brief", "list")
HALVES = ("upper", "lower", "left", "right")
RELATIONS = (
    "same",
    "different",
    "opposite",
    "mirrored",
    "more",
    "less",
    "which-more",
    "which-less",
)
CLIPS = ("first", "second", "both", "each", "either", "neither", "only-one", "previous")
SPANS = ("whole", "start", "end", "first-half", "second-half")


@dataclass(frozen=True)
class Slot:
    """The k-th quantity of the question, from 1."""

    index: int


@dataclass(frozen=True)
class Quantity:
    """A number with its unit; an empty unit where none is said, "deg/s" of a speed."""

    value: float
    unit: str = ""


Number = Slot | Quantity


@dataclass(frozen=True)
class Bound:
    """How an amount is compared: "more", "less" or "about" a number, "between" two."""

    relation: str
    low: Number
    high: Number | None = None


@dataclass(frozen=True)
class Literal:
    """One thing that holds or not, by how much where a bound says so."""

    atom: str
    bound: Bound | None = None
    denied: bool = False

    def deny(self) -> Literal:
        """Return its contrary."""
        return replace(self, denied=not self.denied)


@dataclass(frozen=True)
class Proposition:
    """All of its literals, or any of them.

    Args:
        literals: At least one.
        joint: "and" or "or".
    """

    literals: tuple[Literal, ...]
    joint: str = "and"

    def deny(self) -> Proposition:
        """Return its contrary, by De Morgan's law; of a contrary the first again."""
        joint = {"and": "or", "or": "and"}[self.joint] if len(self.literals) > 1 else self.joint
        return Proposition(tuple(one.deny() for one in self.literals), joint)

    @property
    def denies(self) -> bool:
        """Whether every literal is denied."""
        return all(one.denied for one in self.literals)


@dataclass(frozen=True)
class Option:
    """One of several answers offered, with the label a reply may use ("A", "1")."""

    proposition: Proposition
    label: str | None = None


@dataclass(frozen=True)
class Way:
    """Which way does it go; of a component, or all that happens."""

    of: str | None = None


@dataclass(frozen=True)
class Kind:
    """What kind of motion it is."""


@dataclass(frozen=True)
class Claim:
    """Whether something is so."""

    proposition: Proposition


@dataclass(frozen=True)
class Choice:
    """Which of the options is so, or is not where `denied`."""

    options: tuple[Option, ...]
    denied: bool = False


@dataclass(frozen=True)
class Amount:
    """How far it went.

    Args:
        of: What; None of all that counts.
        unit: Wanted; None for the usual one.
        per: A key of `PER` where a speed is asked for.
        measure: "path" of all ways added up, "peak" of the greatest; None of start to end.
    """

    of: str | None = None
    unit: str | None = None
    per: str | None = None
    measure: str | None = None


@dataclass(frozen=True)
class When:
    """At what time something begins or ends."""

    proposition: Proposition
    edge: str = "begin"


@dataclass(frozen=True)
class HowLong:
    """For how long something lasts."""

    proposition: Proposition


@dataclass(frozen=True)
class HowOften:
    """How many times something happens."""

    proposition: Proposition


@dataclass(frozen=True)
class Order:
    """What comes first and what then; whether two come in the order given."""

    first: str | None = None
    then: str | None = None


@dataclass(frozen=True)
class Why:
    """What an answer rests on."""

    proposition: Proposition | None = None


@dataclass(frozen=True)
class HowSure:
    """How probable something is; the last answer where nothing is named."""

    proposition: Proposition | None = None
    of_amount: bool = False


@dataclass(frozen=True)
class Alternatives:
    """What else it could be."""


@dataclass(frozen=True)
class Place:
    """Where the contact is; whether it is in a half."""

    half: str | None = None


@dataclass(frozen=True)
class Compare:
    """How two clips differ; whether a relation holds of them (the first against the second)."""

    relation: str | None = None
    of: str | None = None
    is_speed: bool = False


@dataclass(frozen=True)
class Which:
    """Of which clip something is so."""

    proposition: Proposition


@dataclass(frozen=True)
class Recording:
    """A fact about the file."""

    topic: str


@dataclass(frozen=True)
class Setup:
    """Which facts on the set-up are taken to hold."""

    topic: str = "frame"


@dataclass(frozen=True)
class Again:
    """What was asked before: in another unit, of another mover, without its changes."""

    unit: str | None = None
    mover: str | None = None
    is_plain: bool = False


@dataclass(frozen=True)
class Help:
    """What can be asked."""


@dataclass(frozen=True)
class Talk:
    """Words that ask nothing."""

    topic: str


@dataclass(frozen=True)
class Unanswerable:
    """A question that touch cannot answer."""

    reason: str


@dataclass(frozen=True)
class NotUnderstood:
    """No reading."""


Ask = (
    Way | Kind | Claim | Choice | Amount | When | HowLong | HowOften | Order | Why | HowSure
    | Alternatives | Place | Compare | Which | Recording | Setup | Again | Help | Talk
    | Unanswerable | NotUnderstood
)  # fmt: skip


@dataclass(frozen=True)
class Span:
    """A part of a recording: a name of `SPANS`, or from one time to another."""

    name: str | None = None
    begin: Number | None = None
    end: Number | None = None


@dataclass(frozen=True)
class Subject:
    """What is asked about: this clip unless it says otherwise.

    Args:
        clip: One of `CLIPS`.
        half: Of the contact, one of `HALVES`.
        span: Of the recording.
    """

    clip: str | None = None
    half: str | None = None
    span: Span | None = None


@dataclass(frozen=True)
class Part:
    """One thing asked, of a subject, seen from a point of view."""

    ask: Ask
    edit: Edit = field(default_factory=Edit)
    subject: Subject = field(default_factory=Subject)


@dataclass(frozen=True)
class Fact:
    """Something stated of the set-up.

    Args:
        name: One of `facts.FACTS`.
        value: Its setting, or None.
        numbers: Its quantities.
        denied: It is said not to hold (any more).
    """

    name: str
    value: str | None = None
    numbers: tuple[Number, ...] = ()
    denied: bool = False


@dataclass(frozen=True)
class Query:
    """What a text asks and states; a mere statement has no parts."""

    parts: tuple[Part, ...] = ()
    facts: tuple[Fact, ...] = ()
    form: str = "sentence"


def filled(value: Any, quantities: tuple[Quantity, ...]) -> Any:
    """Return a query, or a part of one, with its slots replaced by the question's quantities.

    Raises:
        IndexError: If a slot counts beyond them.
    """
    if isinstance(value, Slot):
        return quantities[value.index - 1]
    if isinstance(value, tuple):
        return tuple(filled(one, quantities) for one in value)
    if hasattr(value, "__dataclass_fields__") and not isinstance(value, Quantity | Edit):
        changed = {one.name: filled(getattr(value, one.name), quantities) for one in fields(value)}
        return replace(value, **changed)
    return value
