"""Motion labels and the sign convention.

Arrays are [row, column]; x runs right with columns, y runs down with rows, z into the object.
Positive rotation is clockwise as drawn in the image (x towards y). Every direction names the motion
of the object relative to the sensor, in the camera image, unless a `FrameSpec` says otherwise.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class Motion(StrEnum):
    """What the object does during one clip; the values are the words of the JSON answers."""

    CLOCKWISE = "clockwise"
    COUNTERCLOCKWISE = "counterclockwise"
    LEFT = "left"
    RIGHT = "right"
    UP = "up"
    DOWN = "down"
    PRESS = "press"
    RELEASE = "release"
    STILL = "still"
    NONE = "none"
    """Nothing touches the gel."""


ROTATIONS = (Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE)
SLIDES = (Motion.LEFT, Motion.RIGHT, Motion.UP, Motion.DOWN)
DIRECTED = ROTATIONS + SLIDES
"""Motions that claim a direction in the image plane."""


def signed_amount(
    motion: Motion, *, turn: float, right: float, down: float, inward: float = 0.0
) -> float | None:
    """Return how far a movement goes the way `motion` names, negative against it.

    In the unit of that component; stillness and absence go no way: None.
    """
    return {
        Motion.CLOCKWISE: turn,
        Motion.COUNTERCLOCKWISE: -turn,
        Motion.RIGHT: right,
        Motion.LEFT: -right,
        Motion.DOWN: down,
        Motion.UP: -down,
        Motion.PRESS: inward,
        Motion.RELEASE: -inward,
    }.get(motion)


@dataclass(frozen=True)
class MotionLabel:
    """The truth about one clip, from its first to its last frame.

    Pixels are those of the 224-pixel image; None where the recording does not tell.
    """

    motion: Motion  # the dominant one
    rotation_deg: float = 0.0
    slide_x_mm: float = 0.0  # travel of the object to the right
    slide_y_mm: float = 0.0  # down the image
    depth_change_mm: float = 0.0  # positive when pressing in
    contact_fraction: tuple[float, ...] = ()  # share of the image in contact, one per frame
    # Whether the dominant motion changes the image more than the sensor's noise, as a smooth ball
    # spinning about its own axis does not, and dominates at the contact.
    is_readable: bool = True
    mm_per_px: tuple[float, float] | None = None  # width and height of a pixel on the gel
    travel_px: tuple[float, float] | None = None  # of the middle of the contact, right and down
    radius_px: float = 0.0  # of gyration of the contact; 0 where nothing touches
    # What of the picture's change only the turn, the slide and the press can have made, grey
    # levels; infinite where nothing is known of it.
    visible_grey: tuple[float, float, float] = (math.inf, math.inf, math.inf)

    @property
    def slide_px(self) -> float | None:
        """Length of the travel, pixels of the 224-pixel image; None where their size is unknown."""
        if self.mm_per_px is None:
            return None
        across, down = self.mm_per_px
        return math.hypot(self.slide_x_mm / across, self.slide_y_mm / down)

    @property
    def amount(self) -> float | None:
        """How far it turns, degrees, or slides, `slide_px`; None where it does neither."""
        if self.motion in ROTATIONS:
            return abs(self.rotation_deg)
        return self.slide_px if self.motion in SLIDES else None

    def to_dict(self) -> dict[str, Any]:
        """Return the label as plain JSON values."""
        values = asdict(self) | {"motion": self.motion.value}
        # JSON knows no infinity.
        values["visible_grey"] = [None if math.isinf(grey) else grey for grey in self.visible_grey]
        return {
            k: list(value) if isinstance(value, tuple) else value for k, value in values.items()
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> MotionLabel:
        """Read a label back from `to_dict`."""
        own = {k: tuple(value) if isinstance(value, list) else value for k, value in values.items()}
        visible = values.get("visible_grey") or (None, None, None)
        own["visible_grey"] = tuple(math.inf if grey is None else grey for grey in visible)
        return cls(**own | {"motion": Motion(values["motion"])})
