"""A change of the point of view: a signed rotation of the image, a sign of time, who moves.

Edits form a group; each acts on a twist (turn, right, down, inward) as a signed 4 x 4 matrix.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import Twist

Rotation = tuple[int, int, int, int]
"""Right and down of the new image by those of the old, row by row."""

_SAME: Rotation = (1, 0, 0, 1)
_IMAGES: dict[tuple[str, ...], Rotation] = {
    (): _SAME,
    ("mirror",): (-1, 0, 0, 1),
    ("flip",): (1, 0, 0, -1),
    ("half",): (-1, 0, 0, -1),
    ("quarter-cw",): (0, -1, 1, 0),
    ("quarter-ccw",): (0, 1, -1, 0),
    ("mirror", "quarter-cw"): (0, -1, -1, 0),
    ("mirror", "quarter-ccw"): (0, 1, 1, 0),
}
"""Words, in the order they are done, and what they do."""

_MIRROR = _IMAGES[("mirror",)]
_FLAGS = ("behind", "backwards", "undo", "sensor")
EDIT_WORDS = ("mirror", "flip", "half", "quarter-cw", "quarter-ccw", *_FLAGS)


@dataclass(frozen=True)
class Edit:
    """A point of view other than that of the recording."""

    rotation: Rotation = _SAME  # all that is done to the image together: seen from behind, too
    behind: bool = False  # from the object's side, which mirrors left and right
    backwards: bool = False
    undo: bool = False  # what takes the motion back is told
    sensor: bool = False  # its motion is told, not the object's; inward stays inward

    def then(self, other: Edit) -> Edit:
        """Return this edit and then the other."""
        flags = {name: getattr(self, name) != getattr(other, name) for name in _FLAGS}
        return Edit(_product(other.rotation, self.rotation), **flags)

    def inverse(self) -> Edit:
        """Return the edit that takes this one back: of a rotation its transpose."""
        a, b, c, d = self.rotation
        return replace(self, rotation=(a, c, b, d))

    @property
    def matrix(self) -> NDArray[np.float64]:
        """What it makes of a twist, (4, 4): a signed permutation."""
        a, b, c, d = self.rotation
        in_plane = -1 if self.sensor else 1
        rows = [[a * d - b * c, 0, 0, 0], [0, a, b, 0], [0, c, d, 0], [0, 0, 0, in_plane]]
        return in_plane * self.time * np.array(rows, dtype=np.float64)

    @property
    def time(self) -> int:
        """1, or -1 where the motion is reversed as a whole."""
        return -1 if self.backwards != self.undo else 1

    @property
    def image(self) -> Rotation:
        """What is done to the image itself, before one looks from behind."""
        return _product(_MIRROR, self.rotation) if self.behind else self.rotation

    @property
    def words(self) -> tuple[str, ...]:
        """Its canonical words."""
        names = next(words for words, done in _IMAGES.items() if done == self.image)
        return (*names, *(flag for flag in _FLAGS if getattr(self, flag)))

    @classmethod
    def of(cls, *words: str) -> Edit:
        """Return the edit of some `EDIT_WORDS`, done one after the other."""
        edit = cls()
        for word in words:
            if word in _FLAGS:
                turned = _MIRROR if word == "behind" else _SAME
                edit = edit.then(cls(turned, **{word: True}))
            else:
                edit = edit.then(cls(_IMAGES[(word,)]))
        return edit

    def within(self, base: Edit) -> Edit:
        """Return this edit of what another one tells, from the recorded image.

        "From the object's side" and "the sensor" name where the viewer stands and what moves: of a
        base that has them already they change nothing.
        """
        image = _product(self.image, base.image)
        behind = self.behind or base.behind
        rotation = _product(_MIRROR, image) if behind else image
        return replace(self, rotation=rotation, behind=behind, sensor=self.sensor or base.sensor)

    def of_way(self, way: Motion) -> Motion:
        """Return what a motion becomes; stillness and absence stay."""
        return _way_seen(self, way)

    def of_twist(self, twist: Twist) -> Twist:
        """Return what a twist becomes."""
        old = (twist.turn_deg, twist.right_px, twist.down_px, twist.inward_mm)
        return Twist(*(float(number) for number in self.matrix @ np.array(old)))

    def of_label(self, label: MotionLabel) -> MotionLabel:
        """Return the truth about the clip mirrored or turned by a half.

        What is measured of the first and the last frame tells of no other edit.
        """
        if self.rotation[1] or self.backwards or self.undo or self.sensor:
            raise ValueError(f"a label is mirrored or turned by a half, found {self.words}")
        turn, across, down, _ = np.diag(self.matrix).tolist()
        travel = label.travel_px
        return replace(
            label,
            motion=self.of_way(label.motion),
            rotation_deg=turn * label.rotation_deg,
            slide_x_mm=across * label.slide_x_mm,
            slide_y_mm=down * label.slide_y_mm,
            travel_px=travel and (across * travel[0], down * travel[1]),
        )


def _product(left: Rotation, right: Rotation) -> Rotation:
    a, b, c, d = left
    e, f, g, h = right
    return (a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h)


_UNITS: dict[Motion, tuple[int, int, int, int]] = {
    Motion.CLOCKWISE: (1, 0, 0, 0),
    Motion.COUNTERCLOCKWISE: (-1, 0, 0, 0),
    Motion.RIGHT: (0, 1, 0, 0),
    Motion.LEFT: (0, -1, 0, 0),
    Motion.DOWN: (0, 0, 1, 0),
    Motion.UP: (0, 0, -1, 0),
    Motion.PRESS: (0, 0, 0, 1),
    Motion.RELEASE: (0, 0, 0, -1),
}
"""Ways as unit twists."""


@cache
def _way_seen(edit: Edit, way: Motion) -> Motion:
    unit = _UNITS.get(way)
    if unit is None:
        return way
    seen = tuple(int(number) for number in edit.matrix @ np.array(unit))
    return next(name for name, other in _UNITS.items() if other == seen)


MIRRORED, BACKWARDS = Edit.of("mirror"), Edit.of("backwards")
"""The image flipped left to right; the clip played backwards."""


def opposite(way: Motion) -> Motion:
    """Return the motion that takes another one back."""
    return BACKWARDS.of_way(way)
