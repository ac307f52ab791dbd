"""What there is to see of a motion: how much it changes the picture, and which part dominates.

Works on noise-free frames, or on the surface alone; knows where the object touches, not which
object it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.twist import Twist
from geotlm_lm.simulation.idle import MEASURED_IDLE
from geotlm_lm.simulation.optics import turned_lights
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import Optics, Scene
from geotlm_lm.simulation.visibility import visible_change

READABLE_GREY = 2.0
"""RMS change of the noise-free image over the contact, in grey levels, below which a motion drowns:
one frame's noise has a standard deviation of 1.2 to 2.0 grey levels, measured."""


@dataclass(frozen=True)
class Trace:
    """What there is to see of a motion between the first frame and a later one.

    Args:
        change_grey: RMS change of the noise-free image over the contact, grey levels.
        turn_mm: Path of the object by turning, at the contact's radius of gyration.
        slide_mm: Travel of the object at the contact's centre.
        travel_px: The same to the right and down, pixels of the 224-pixel image.
        radius_px: Radius of gyration of the contact, likewise.
        visible_grey: What only turn, slide and press can have changed, as
            `visibility.visible_change` has it.
    """

    change_grey: float = 0.0
    turn_mm: float = 0.0
    slide_mm: float = 0.0
    travel_px: tuple[float, float] = (0.0, 0.0)
    radius_px: float = 0.0
    visible_grey: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def shows(self, motion: Motion, dominance: float = 1.0) -> bool:
        """Tell whether a camera could see `motion`, and whether it is so many times the greater.

        A turn about an axis far beside the contact carries the contact along farther than it turns
        it: its picture is a slide's, whatever the hand did.
        """
        is_greater = True
        if motion in ROTATIONS:
            is_greater = self.turn_mm >= dominance * self.slide_mm
        elif motion in SLIDES:
            is_greater = self.slide_mm >= dominance * self.turn_mm
        return is_greater and self.change_grey >= READABLE_GREY


def trace_of(
    scene: Scene,
    profile: Profile | None,
    change_until: Callable[[int], float],
    touches: NDArray[np.bool_],
    last: int,
) -> Trace:
    """Return what there is to see between frame 0 and frame `last`.

    Args:
        scene: Poses and pixel sizes.
        profile: The body; None where it never comes near.
        change_until: Frame number -> change of the picture over the contact since frame 0, in grey
            levels.
        touches: Where the object is against the gel, (frames, 224, 224).
        last: The later frame.
    """
    frame = last if touches[last].any() else 0
    if last == 0 or not touches[frame].any():
        return Trace()
    contact = Contact.of(scene, touches[frame])
    x, y, turn_rad = motion_at_contact(scene, contact.middle_mm, last)
    travel_px = x / scene.optics.mm_per_px_x, y / scene.optics.mm_per_px_y
    inward_mm = scene.path.depth_mm[last] - scene.path.depth_mm[0]
    twist = Twist(math.degrees(turn_rad), *travel_px, inward_mm)
    visible = (0.0, 0.0, 0.0)
    if profile is not None:
        visible = visible_change(scene, profile, frame, contact.middle_mm, contact.radius_px, twist)
    return Trace(
        change_grey=change_until(last),
        turn_mm=abs(turn_rad) * contact.radius_mm,
        slide_mm=float(np.hypot(x, y)),
        travel_px=travel_px,
        radius_px=contact.radius_px,
        visible_grey=visible,
    )


@dataclass(frozen=True)
class Contact:
    """Where the object touches: the middle, and the radius of gyration about it."""

    middle_mm: tuple[float, float]
    radius_mm: float
    radius_px: float

    @classmethod
    def of(cls, scene: Scene, touches: NDArray[np.bool_]) -> Contact:
        """Return the contact of one frame, where `touches` (224, 224) is true somewhere."""
        optics, axis = scene.optics, np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2
        x, by_column = axis * optics.mm_per_px_x, touches.mean(axis=0, dtype=np.float32)
        y, by_row = axis * optics.mm_per_px_y, touches.mean(axis=1, dtype=np.float32)
        by_column, by_row = by_column / by_column.sum(), by_row / by_row.sum()
        middle_x, middle_y = float(by_column @ x), float(by_row @ y)
        across, down = by_column @ (x - middle_x) ** 2, by_row @ (y - middle_y) ** 2
        in_px = across / optics.mm_per_px_x**2 + down / optics.mm_per_px_y**2
        return cls((middle_x, middle_y), float(np.sqrt(across + down)), float(np.sqrt(in_px)))


def change_since_first(
    clean: list[NDArray[np.float32]], touches: NDArray[np.bool_], last: int
) -> float:
    """Return the change between frame 0 and frame `last` of noise-free planar frames."""
    return image_change(clean[0], clean[last], touches[0] | touches[last])


def shading_change(
    optics: Optics, indentation_mm: NDArray[np.float32], touches: NDArray[np.bool_], last: int
) -> float:
    """Return about what `image_change` would, from the surface alone, without any picture.

    The lights' shading of the surface, softened on steep slopes, on a gel of the measured mean grey
    level; uneven light, shadows, blur and specks are left out.

    Args:
        optics: Lights and pixel sizes.
        indentation_mm: (frames, 224, 224).
        touches: Where the object is against the gel, likewise.
        last: The later frame.
    """
    where = touches[0] | touches[last]
    if not where.any():
        return 0.0
    change = 0.0
    for sign, depth in ((1, indentation_mm[last]), (-1, indentation_mm[0])):
        slopes = [
            -cv2.Sobel(depth, cv2.CV_32F, *axis, ksize=3, scale=0.125 / size)[where]
            for axis, size in (((1, 0), optics.mm_per_px_x), ((0, 1), optics.mm_per_px_y))
        ]
        steep = np.square(slopes).sum(axis=0)
        soft = np.stack(slopes) / np.sqrt(1 + optics.saturation**2 * steep)
        shade = turned_lights(optics) @ soft + np.outer(optics.depth_gain, depth[where])
        change = change + sign * (shade - 2 * optics.steep_darkening * steep / (1 + steep))
    # Of the idle frame's measured points, the inner nine: few contacts lie at the border.
    levels = MEASURED_IDLE[:, 1:-1, 1:-1].mean(axis=(1, 2))[:, None]
    return float(np.sqrt(np.square(levels * change).mean()))


def motion_at_contact(
    scene: Scene, middle_mm: tuple[float, float], last: int
) -> tuple[float, float, float]:
    """Return how far the object has come at the middle of the contact since frame 0.

    Args:
        scene: Poses.
        middle_mm: Where the middle lies in frame `last`, (x, y).
        last: The later frame.

    Returns:
        Travel of the contact's middle to the right and down in mm, and the turn in rad, clockwise
        positive.
    """
    path, (middle_x, middle_y) = scene.path, middle_mm
    turn = path.rotation_rad[last] - path.rotation_rad[0]
    # The point now at the middle stood at c0 + R(-turn)(middle - c).
    from_x, from_y = middle_x - path.x_mm[last], middle_y - path.y_mm[last]
    moved_x = middle_x - (path.x_mm[0] + np.cos(turn) * from_x + np.sin(turn) * from_y)
    moved_y = middle_y - (path.y_mm[0] - np.sin(turn) * from_x + np.cos(turn) * from_y)
    return float(moved_x), float(moved_y), float(turn)


def image_change(
    first: NDArray[np.float32], last: NDArray[np.float32], touches: NDArray[np.bool_]
) -> float:
    """Return the RMS difference of two planar images over `touches`, 0 where nothing touches."""
    if not touches.any():
        return 0.0
    mask, planes = touches.view(np.uint8), zip(first, last, strict=True)
    # Norms under a mask cost a sixth of picking the pixels out.
    squares = sum(cv2.norm(one, other, cv2.NORM_L2SQR, mask) for one, other in planes)
    return float(np.sqrt(squares / (len(first) * np.count_nonzero(touches))))
