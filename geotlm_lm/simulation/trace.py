"""What there is to see of a motion: how much it changes the picture, and what else would as much.

Works on noise-free frames; knows where the object touches, not which object it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion
from geotlm_lm.simulation.scene import Scene

READABLE_GREY = 2.0
"""RMS change of the noise-free image over the contact, in grey levels, below which a motion drowns:
one frame's noise has a standard deviation of 1.2 to 2.0 grey levels, measured."""

NAMED_GREY = 1.0
"""RMS difference over the contact from the picture of a motion with another name, in grey levels,
below which the names cannot be told apart: the best read-out of one backbone was right about 4 of
11 such turns, about 18 of 27 up to twice as far, and about nine in ten from there on."""


@dataclass(frozen=True)
class Trace:
    """What there is to see of a motion between the first frame and a later one.

    Args:
        change_grey: RMS change of the noise-free image over the contact, grey levels.
        turn_mm: Path of the object by turning, at the contact's radius of gyration.
        slide_mm: Travel of the object at the contact's centre.
        margin_grey: RMS difference, over the contact, from the picture that the most similar motion
            with another name would leave.
    """

    change_grey: float = 0.0
    turn_mm: float = 0.0
    slide_mm: float = 0.0
    margin_grey: float = np.inf

    def shows(self, motion: Motion) -> bool:
        """Tell whether a camera could see `motion`, and no other one of another name instead.

        A turn about an axis far beside the contact carries the contact along farther than it turns
        it: its picture is a slide's, whatever the hand did. And an edge that slides along itself
        looks the same as one that slides across at the same pace.
        """
        is_greater = True
        if motion in ROTATIONS:
            is_greater = self.turn_mm >= self.slide_mm
        elif motion in SLIDES:
            is_greater = self.slide_mm >= self.turn_mm
        is_named = self.margin_grey >= NAMED_GREY
        return is_greater and is_named and self.change_grey >= READABLE_GREY


def trace_of(
    scene: Scene, clean: list[NDArray[np.float32]], touches: NDArray[np.bool_], last: int
) -> Trace:
    """Return what there is to see between frame 0 and frame `last`.

    Args:
        scene: Poses and pixel sizes.
        clean: Noise-free planar frames.
        touches: Where the object is against the gel, (frames, 224, 224).
        last: The later frame.
    """
    change = image_change(clean[0], clean[last], touches[0] | touches[last])
    contact = touches[last] if touches[last].any() else touches[0]
    if not contact.any():
        return Trace(change)
    x, y, turn_mm, middle = motion_at_contact_mm(scene, contact, last)
    margin = np.inf
    if scene.motion in DIRECTED:
        slopes = motion_products(clean[last], contact, scene, middle)
        margin = margin_grey(slopes, np.array([x, y, turn_mm]), scene.motion)
    return Trace(change, abs(turn_mm), float(np.hypot(x, y)), margin)


@dataclass(frozen=True)
class Middle:
    """Where a contact lies, from the middle of the image, and how far it reaches, in mm."""

    x: float
    y: float
    gyration: float


def motion_at_contact_mm(
    scene: Scene, contact: NDArray[np.bool_], last: int
) -> tuple[float, float, float, Middle]:
    """Return how far the object has come at the contact since frame 0.

    Args:
        scene: Poses and pixel sizes.
        contact: Where the object is against the gel in frame `last`, (224, 224), somewhere.
        last: The later frame.

    Returns:
        Travel of the contact's middle to the right and down, and path by turning at its radius of
        gyration, clockwise positive; in mm. And the middle.
    """
    count = contact.sum()
    path, optics = scene.path, scene.optics
    axis = np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2
    x, by_column = axis * optics.mm_per_px_x, contact.sum(axis=0) / count
    y, by_row = axis * optics.mm_per_px_y, contact.sum(axis=1) / count
    middle_x, middle_y = float(by_column @ x), float(by_row @ y)
    gyration = np.sqrt(by_column @ (x - middle_x) ** 2 + by_row @ (y - middle_y) ** 2)
    turn = path.rotation_rad[last] - path.rotation_rad[0]
    # The point now at the middle stood at c0 + R(-turn)(middle - c).
    from_x, from_y = middle_x - path.x_mm[last], middle_y - path.y_mm[last]
    moved_x = middle_x - (path.x_mm[0] + np.cos(turn) * from_x + np.sin(turn) * from_y)
    moved_y = middle_y - (path.y_mm[0] - np.sin(turn) * from_x + np.cos(turn) * from_y)
    middle = Middle(middle_x, middle_y, float(gyration))
    return float(moved_x), float(moved_y), float(turn * gyration), middle


def motion_products(
    clean: NDArray[np.float32], contact: NDArray[np.bool_], scene: Scene, middle: Middle
) -> NDArray[np.float64]:
    """Return how a small motion changes the picture: mean products over the contact, (3, 3).

    For a motion u = (right, down, turning path), u @ products @ u is the mean squared change of
    grey levels per mm^2, to first order.

    Args:
        clean: Noise-free planar frame (3, 224, 224).
        contact: Where the object is against the gel, (224, 224).
        scene: Pixel sizes.
        middle: Of the contact.
    """
    # Every third pixel: the products hardly change, and clips are made a hundred a second.
    rows, columns = np.nonzero(contact[1:-1:3, 1:-1:3])
    if not len(rows):
        return np.zeros((3, 3))
    rows, columns = 3 * rows + 1, 3 * columns + 1
    step_x, step_y = 2 * scene.optics.mm_per_px_x, 2 * scene.optics.mm_per_px_y
    slope_x = (clean[:, rows, columns + 1] - clean[:, rows, columns - 1]) / step_x
    slope_y = (clean[:, rows + 1, columns] - clean[:, rows - 1, columns]) / step_y
    x = (columns - (IMAGE_SIDE - 1) / 2) * scene.optics.mm_per_px_x - middle.x
    y = (rows - (IMAGE_SIDE - 1) / 2) * scene.optics.mm_per_px_y - middle.y
    turning = (slope_y * x - slope_x * y) / max(middle.gyration, 1e-3)
    parts = np.stack([slope_x, slope_y, turning]).reshape(3, -1).astype(np.float64)
    return parts @ parts.T / parts.shape[1]


def margin_grey(
    products: NDArray[np.float64], motion_mm: NDArray[np.float64], motion: Motion
) -> float:
    """Return how much the picture differs from that of the nearest motion of another name.

    Args:
        products: From `motion_products`.
        motion_mm: What the object does: right, down, turning path.
        motion: Its name.

    Returns:
        RMS grey levels, over all turns, slides and mixtures up to three times as far.
    """
    ways, names = _ways()
    ways = ways[names != motion]
    mixed = ways @ products
    own, square = mixed @ motion_mm, np.einsum("ij,ij->i", mixed, ways)
    most = 3 * np.linalg.norm(motion_mm)
    far = np.clip(own / np.maximum(square, 1e-12), 0, most)
    differences = motion_mm @ products @ motion_mm - 2 * far * own + far**2 * square
    return float(np.sqrt(max(differences.min(), 0.0)))


@lru_cache(maxsize=1)
def _ways() -> tuple[NDArray[np.float64], NDArray[np.str_]]:
    """Return motions of unit length every five degrees, (n, 3), and what each is called, (n,)."""
    towards, lift = np.radians(np.arange(0, 360, 5)), np.radians(np.arange(-90, 91, 5))
    towards, lift = (one.ravel() for one in np.meshgrid(towards, lift))
    ways = np.stack([np.cos(towards) * np.cos(lift), np.sin(towards) * np.cos(lift), np.sin(lift)])
    right, down, turn = ways
    sideways = np.where(right > 0, Motion.RIGHT, Motion.LEFT)
    slide = np.where(np.abs(right) >= np.abs(down), sideways, np.where(down > 0, "down", "up"))
    rotation = np.where(turn > 0, Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE)
    return ways.T, np.where(np.abs(turn) >= np.hypot(right, down), rotation, slide)


def image_change(
    first: NDArray[np.float32], last: NDArray[np.float32], touches: NDArray[np.bool_]
) -> float:
    """Return the RMS difference of two planar images over `touches`, 0 where nothing touches."""
    if not touches.any():
        return 0.0
    square = np.square(last - first).sum(axis=0)
    return float(np.sqrt(square[touches].mean() / len(first)))
