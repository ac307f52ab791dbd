"""The frame of reference an answer is told in, and how a motion reads from another frame."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from numbers import Real
from typing import Any, Literal, get_args

from geotlm_lm.core.edit import MIRRORED, Edit
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import ROTATIONS, Motion

Viewpoint = Literal["sensor", "object"]
Actor = Literal["object", "sensor"]
ContactSide = Literal["head", "shank", "side"]
Thread = Literal["right", "left"]
QuarterTurn = Literal["clockwise", "counterclockwise"]

_CHOICES: dict[str, tuple[Any, ...]] = {
    "image_mirrored": (True, False),
    "viewpoint": get_args(Viewpoint),
    "actor": get_args(Actor),
    "contact_side": (*get_args(ContactSide), None),
    "thread": (*get_args(Thread), None),
    "image_upside_down": (True, False),
    "image_quarter_turn": (*get_args(QuarterTurn), None),
}
"""What each field may be."""

RATES_HZ = (0.1, 10_000.0)
"""Least and most frames per second that can be stated."""

MM_PER_PX = (0.001, 2.0)
"""Least and most a pixel can measure: cameras see a few mm to a few dm of gel."""


@dataclass(frozen=True)
class FrameSpec:
    """Facts about the recording that decide what a direction means.

    A recorded image is what the camera sees of the object, flipped if it is mirrored, and then
    turned if it is upside down or turned by a quarter: whoever makes it upright turns it back
    first, and undoes the mirror left to right after that.

    Args:
        image_mirrored: The recorded image is flipped left to right against the camera's view.
        viewpoint: From which side the direction is told: looking out of the sensor, or at it.
        actor: Whose motion is told: the object's relative to the sensor, or the sensor's.
        contact_side: Which side of a screw or cap touches the gel; None when unknown.
        thread: Handedness of a thread; None when unknown.
        image_upside_down: Directions are told for the image turned by 180 degrees: the recorded one
            is upside down, as from a camera mounted on its head, or a question supposes it.
        mm_per_px: Width on the gel of a pixel of the recording's frames; None when unknown.
        image_quarter_turn: The recorded image is turned by 90 degrees that way against an upright
            one, and directions are told for the image turned back. A camera that is itself turned
            clockwise, as seen from behind it, records an image turned counterclockwise.
        rate_hz: Frames per second, whatever a clip's file says, unless its frames are unevenly
            timed or it was followed; None for what the file says. Of two clips it is that of those
            whose files say nothing.

    Raises:
        UsageError: If a field is none of what it may be, if an image is both upside down and turned
            by a quarter, or if no camera has pixels of that size or that rate.
    """

    image_mirrored: bool = False
    viewpoint: Viewpoint = "sensor"
    actor: Actor = "object"
    contact_side: ContactSide | None = None
    thread: Thread | None = None
    image_upside_down: bool = False
    mm_per_px: float | None = None
    image_quarter_turn: QuarterTurn | None = None
    rate_hz: float | None = None

    def __post_init__(self) -> None:
        for name, choices in _CHOICES.items():
            _require_one_of(choices, name, getattr(self, name))
        _require_size(self.mm_per_px)
        low, high = RATES_HZ
        if self.rate_hz is not None and not low <= self.rate_hz <= high:
            raise UsageError(
                f"A rate of {self.rate_hz:g} frames per second was given, expected {low:g} to "
                f"{high:g}; give the rate at which the camera took them."
            )
        if self.image_upside_down and self.image_quarter_turn is not None:
            other = next(turn for turn in get_args(QuarterTurn) if turn != self.image_quarter_turn)
            raise UsageError(
                f"An image both upside down and turned {self.image_quarter_turn} by 90 degrees was "
                f"given, expected one of the two; for both together give "
                f"image_quarter_turn={other!r} alone."
            )

    @staticmethod
    def fields_of_turn(degrees: float) -> dict[str, Any]:
        """Return the fields that say that the recorded image is turned by `degrees` clockwise.

        They are a multiple of 90 of either sign, as the turn is seen in the recorded image.
        """
        quarters: dict[float, QuarterTurn] = {90: "clockwise", 270: "counterclockwise"}
        turn = degrees % 360
        return {"image_upside_down": turn == 180, "image_quarter_turn": quarters.get(turn)}

    @property
    def edit(self) -> Edit:
        """What makes of a motion of the object in the recorded image the one this frame tells.

        An image turned by a quarter is turned back and one upside down turns a slide around, both
        leave a turn as it is; then a mirrored recording and the view from the object's side each
        flip left and right; telling the sensor's motion instead of the object's turns any direction
        around. Pressing stays pressing whatever moves.
        """
        turned = {0: (), 90: ("quarter-ccw",), 180: ("half",), 270: ("quarter-cw",)}
        words = [*turned[self.turn_deg], *("mirror",) * self.image_mirrored]
        words += ("behind",) * (self.viewpoint == "object")
        return Edit.of(*words, *("sensor",) * (self.actor == "sensor"))

    def summary(self) -> str:
        """Return all known facts in one clause."""
        facts = [self.sentence()]
        if self.thread is not None:
            facts.append(f"{self.thread}-hand thread")
        if self.contact_side is not None:
            facts.append(f"touched at its {self.contact_side}")
        if self.mm_per_px is not None:
            facts.append(f"{self.mm_per_px:g} mm per pixel")
        if self.rate_hz is not None:
            facts.append(f"{self.rate_hz:g} frames per second")
        return ", ".join(facts)

    def missing_for_thread(self) -> tuple[str, ...]:
        """Return the names of the facts still needed to tell tightening from loosening."""
        return tuple(name for name in ("contact_side", "thread") if getattr(self, name) is None)

    def tightens(self, motion: Motion) -> bool | None:
        """Tell whether `motion` of the object in the camera image tightens its thread.

        A right-hand thread seen from its head tightens clockwise; the shank side and a left-hand
        thread each invert that. None when the motion is no rotation, when a fact is missing, or
        when the gel touches the side, where a cap's turn shows as a slide.
        """
        if motion not in ROTATIONS or self.missing_for_thread() or self.contact_side == "side":
            return None
        seen = MIRRORED.of_way(motion) if self.image_mirrored else motion
        inversions = (self.contact_side == "shank") + (self.thread == "left")
        return (seen == Motion.CLOCKWISE) == (inversions % 2 == 0)

    @property
    def turn_deg(self) -> int:
        """Degrees by which the recorded image is turned clockwise: 0, 90, 180 or 270."""
        quarter = {None: 0, "clockwise": 90, "counterclockwise": 270}[self.image_quarter_turn]
        return 180 if self.image_upside_down else quarter

    def turning(self) -> str:
        """Return how the recorded image is turned before directions are told; "" if it is not."""
        if self.image_quarter_turn is None:
            return "turned by 180 degrees" if self.image_upside_down else ""
        back = "counterclockwise" if self.image_quarter_turn == "clockwise" else "clockwise"
        return f"turned back by 90 degrees {back}"

    def sentence(self) -> str:
        """Return the frame in words, as answers state it."""
        image = f"camera image {self.turning()}".rstrip()
        image += " with the mirror undone" if self.image_mirrored else ""
        side = "looking out of the sensor" if self.viewpoint == "sensor" else "seen from the object"
        whose = "object relative to sensor" if self.actor == "object" else "sensor past the object"
        return f"{image}, {side}, {whose}"

    def to_dict(self) -> dict[str, Any]:
        """Return the fields and the sentence as plain JSON values."""
        return asdict(self) | {"sentence": self.sentence()}


def _require_one_of(choices: tuple[Any, ...], name: str, value: Any) -> None:
    # 1 equals True and an array compares by element: the kind of value is asked first.
    kinds = tuple({type(choice) for choice in choices})
    if isinstance(value, kinds) and value in choices:
        return
    *others, last = (repr(choice) for choice in choices)
    raise UsageError(
        f"{name} was {value!r}, expected {', '.join(others)} or {last}; give one of these as it is "
        f"written here, or leave {name} out."
    )


def _require_size(mm_per_px: Any) -> None:
    low, high = MM_PER_PX
    if mm_per_px is None:
        return
    if not isinstance(mm_per_px, Real) or isinstance(mm_per_px, bool):
        raise UsageError(
            f"mm_per_px was {mm_per_px!r}, expected a number from {low:g} to {high:g} or None; "
            f"give the millimetres of gel that a pixel is wide, or leave mm_per_px out."
        )
    if not low <= mm_per_px <= high:
        raise UsageError(
            f"A pixel of {mm_per_px:g} mm was given, expected {low:g} to {high:g} mm, "
            f"such as 0.06 of a GelSight Mini's 320x240; divide the mm of gel that are seen by "
            f"the image's columns."
        )
