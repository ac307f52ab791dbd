"""Plain values that programs and facts hold, and the words that they may hold."""

from __future__ import annotations

from dataclasses import dataclass

from geotlm_lm.core.labels import Motion

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
"""Words of programs for ways, and the motions that they are."""

ATOM_OF = {way: atom for atom, way in WAY_ATOMS.items()}

UNITS = {
    "angle": ("deg", "rad", "mrad", "gon", "turn", "arcmin"),
    "length": ("px", "mm", "cm", "m", "um", "inch", "thou"),
    "time": ("s", "ms", "us", "min", "frame"),
    "share": ("percent",),
}

UNANSWERABLE = (
    "force", "identity", "material", "look", "size", "quality", "temperature", "sound", "future",
    "advice", "cause", "place", "tilt", "axis", "world", "language", "off-topic",
)  # fmt: skip
"""What is asked that touch, or this program, cannot tell."""

TALK = ("greeting", "thanks", "fine", "bye", "doubt", "who", "statement")
TOPICS = ("duration", "frames", "rate", "interval", "size", "used", "scale")
SETTINGS = ("frame", "mirrored", "turned", "mover", "thread", "side", "options")


@dataclass(frozen=True)
class Slot:
    """The k-th quantity of the question, from 1."""

    index: int


@dataclass(frozen=True)
class Quantity:
    """A number with its unit; an empty unit where none is told, "deg/s" of a speed."""

    value: float
    unit: str = ""


Number = Slot | Quantity


@dataclass(frozen=True)
class Fact:
    """Something stated of the set-up.

    Args:
        name: One of `facts.FACTS`.
        value: Its setting, or None.
        numbers: Its quantities.
        denied: It is stated not to hold (any more).
    """

    name: str
    value: str | None = None
    numbers: tuple[Number, ...] = ()
    denied: bool = False
