"""What there is to see of a motion: how much it changes the picture, and which part is the greater.

Works on noise-free frames, or on the surface alone; knows where the object touches, not which
object it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.simulation.idle import MEASURED_IDLE
from geotlm_lm.simulation.optics import turned_lights
from geotlm_lm.simulation.scene import Optics, Scene

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
    """

    change_grey: float = 0.0
    turn_mm: float = 0.0
    slide_mm: float = 0.0

    def shows(self, motion: Motion) -> bool:
        """Tell whether a camera could see `motion`, and whether it is the greater one.

        A turn about an axis far beside the contact carries the contact along farther than it turns
        it: its picture is a slide's, whatever the hand did.
        """
        is_greater = True
        if motion in ROTATIONS:
            is_greater = self.turn_mm >= self.slide_mm
        elif motion in SLIDES:
            is_greater = self.slide_mm >= self.turn_mm
        return is_greater and self.change_grey >= READABLE_GREY


def trace_of(
    scene: Scene, change_until: Callable[[int], float], touches: NDArray[np.bool_], last: int
) -> Trace:
    """Return what there is to see between frame 0 and frame `last`.

    Args:
        scene: Poses and pixel sizes.
        change_until: Frame number -> change of the picture over the contact since frame 0, in grey
            levels.
        touches: Where the object is against the gel, (frames, 224, 224).
        last: The later frame.
    """
    contact = touches[last] if touches[last].any() else touches[0]
    if last == 0 or not contact.any():
        return Trace()
    x, y, turn_mm = motion_at_contact_mm(scene, contact, last)
    return Trace(change_until(last), abs(turn_mm), float(np.hypot(x, y)))


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


def motion_at_contact_mm(
    scene: Scene, contact: NDArray[np.bool_], last: int
) -> tuple[float, float, float]:
    """Return how far the object has come at the contact since frame 0.

    Args:
        scene: Poses and pixel sizes.
        contact: Where the object is against the gel in frame `last`, (224, 224), somewhere.
        last: The later frame.

    Returns:
        Travel of the contact's middle to the right and down, and path by turning at its radius of
        gyration, clockwise positive; in mm.
    """
    path, optics = scene.path, scene.optics
    axis = np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2
    x, by_column = axis * optics.mm_per_px_x, contact.mean(axis=0, dtype=np.float32)
    y, by_row = axis * optics.mm_per_px_y, contact.mean(axis=1, dtype=np.float32)
    by_column, by_row = by_column / by_column.sum(), by_row / by_row.sum()
    middle_x, middle_y = float(by_column @ x), float(by_row @ y)
    gyration = np.sqrt(by_column @ (x - middle_x) ** 2 + by_row @ (y - middle_y) ** 2)
    turn = path.rotation_rad[last] - path.rotation_rad[0]
    # The point now at the middle stood at c0 + R(-turn)(middle - c).
    from_x, from_y = middle_x - path.x_mm[last], middle_y - path.y_mm[last]
    moved_x = middle_x - (path.x_mm[0] + np.cos(turn) * from_x + np.sin(turn) * from_y)
    moved_y = middle_y - (path.y_mm[0] - np.sin(turn) * from_x + np.cos(turn) * from_y)
    return float(moved_x), float(moved_y), float(turn * gyration)


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
