"""What a question means, as plain values: asks, the point of view, facts stated on the way.

A number is never spelled: it is the k-th quantity of the question (`Slot`) until `filled`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component

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
    "length": ("px", "mm", "cm", "um", "inch", "thou"),
    "time": ("s", "ms", "min", "frame"),
    "share": ("percent",),
}
PER = {"per-s": 1.0, "per-min": 60.0, "per-frame": None}
"""Times that an amount may be told per, in seconds; a frame's follows from the recording."""

UNANSWERABLE = (
    "force", "identity", "material", "look", "size", "quality", "temperature", "sound", "future",
    "advice", "cause", "place", "tilt", "axis", "world", "language", "off-topic",
)  # fmt: skip
"""What is asked that touch, or this program, cannot tell."""

TALK = ("greeting", "thanks", "fine", "bye", "doubt", "who")
TOPICS = ("duration", "frames", "rate", "interval", "size", "used", "scale")
SETTINGS = ("frame", "mirrored", "turned", "mover", "thread", "side", "options")
FORMS = ("sentence", "word", "letter", "number", "sign", "yes-no", "json", "brief", "list")
HALVES = ("upper", "lower", "left", "right")
RELATIONS = (
    "same", "different", "opposite", "mirrored", "more", "less", "which-more", "which-less",
)  # fmt: skip
CLIPS = ("first", "second", "both", "each", "either", "neither", "only-one", "previous")
OF_SEVERAL = CLIPS[2:7]
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


ASKS: dict[str, tuple[str, ...]] = {
    "way": ("of",),  # which way; of a component, or all that happens
    "kind": (),  # what kind of motion
    "claim": ("proposition",),  # whether it is so
    "choice": ("options", "denied"),  # which option is so, or is not
    "amount": ("of", "unit", "per", "measure"),  # how far, how fast
    "when": ("proposition", "edge"),  # at what time it begins or ends
    "how-long": ("proposition",),  # for what time
    "how-often": ("proposition",),  # how many times
    "order": ("of", "then"),  # what comes first; whether two come in that order
    "why": ("proposition",),  # what an answer rests on
    "how-sure": ("proposition", "of_amount"),  # how probable it is; or the last answer
    "alternatives": (),  # what else it could be
    "place": ("half",),  # where the contact is; whether in a half
    "compare": ("relation", "of", "is_speed"),  # of two clips, the first against the second
    "which-clip": ("proposition",),  # of which clip it is so
    "recording": ("topic",),  # a fact about the file
    "setup": ("topic",),  # which facts on the set-up are taken to hold
    "again": ("unit", "mover", "is_plain"),  # what was asked before, changed
    "help": (),  # what can be asked
    "talk": ("topic",),  # words that ask nothing
    "unanswerable": ("topic",),  # what touch cannot answer, and why
    "not-understood": (),
}
"""Kinds of what may be asked, and the fields of `Ask` that each has, in their order."""


@dataclass(frozen=True)
class Ask:
    """One thing that is asked.

    Args:
        kind: A key of `ASKS`, which says what else is set.
        proposition: What it is about; of "why" and "how-sure" None is the last answer.
        options: Answers that are offered.
        denied: The options that are not so are asked for.
        of: A component or other atom; None of all that counts.
        then: What comes second.
        unit: Wanted; None for the usual one.
        per: A key of `PER` where a speed is asked for.
        measure: "path" of all ways added up, "peak" of the greatest; None of start to end.
        edge: "begin" or "end".
        relation: One of `RELATIONS`.
        is_speed: Speeds are compared, not amounts.
        of_amount: How exact the last amount is.
        half: One of `HALVES`.
        topic: One of `TOPICS`, `SETTINGS`, `TALK` or `UNANSWERABLE`.
        mover: "object" or "sensor", whichever it was before.
        is_plain: Without the changes that were asked for before.
    """

    kind: str
    proposition: Proposition | None = None
    options: tuple[Option, ...] = ()
    denied: bool = False
    of: str | None = None
    then: str | None = None
    unit: str | None = None
    per: str | None = None
    measure: str | None = None
    edge: str | None = None
    relation: str | None = None
    is_speed: bool = False
    of_amount: bool = False
    half: str | None = None
    topic: str | None = None
    mover: str | None = None
    is_plain: bool = False


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
