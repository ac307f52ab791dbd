"""The truth about a clip: its label, and the object's motion patch by patch; draws no picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import GRID_SIDE, IMAGE_SIDE, PATCH_SIDE
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.simulation.scene import Scene

READABLE_GREY = 2.0
"""RMS change of the noise-free image over the contact, in grey levels, below which a motion drowns:
one frame's noise has a standard deviation of 1.2 to 2.0 grey levels, measured."""

READABLE_CONTACT = 0.005
"""Share of the view that must be in contact for a motion to be read at all: one patch of 14x14."""


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


def label_for(
    scene: Scene, contact_fraction: NDArray[np.floating], trace: Trace, last: int = -1
) -> MotionLabel:
    """Return the label of a clip from its first frame to its frame `last`.

    Args:
        scene: What was simulated.
        contact_fraction: Share of the view in contact, one number per labelled frame.
        trace: What there is to see between the two frames.
        last: The frame the label counts to.
    """
    path = scene.path
    return MotionLabel(
        motion=scene.motion,
        rotation_deg=float(np.degrees(path.rotation_rad[last] - path.rotation_rad[0])),
        slide_x_mm=path.x_mm[last] - path.x_mm[0],
        slide_y_mm=path.y_mm[last] - path.y_mm[0],
        depth_change_mm=path.depth_mm[last] - path.depth_mm[0],
        contact_fraction=tuple(round(float(share), 5) for share in contact_fraction),
        is_readable=is_readable(scene.motion, contact_fraction, trace),
    )


def is_readable(motion: Motion, contact_fraction: NDArray[np.floating], trace: Trace) -> bool:
    """Tell whether the frames show the motion; stillness and absence always can be seen."""
    if motion in (Motion.STILL, Motion.NONE):
        return True
    touched = contact_fraction if motion in DIRECTED else [np.max(contact_fraction)]
    return bool(np.min(touched) >= READABLE_CONTACT and trace.shows(motion))


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
    return Trace(change, *contact_paths_mm(scene, contact, last))


def contact_paths_mm(scene: Scene, contact: NDArray[np.bool_], last: int) -> tuple[float, float]:
    """Return how far the object turned and travelled at the contact since frame 0, both in mm.

    Args:
        scene: Poses and pixel sizes.
        contact: Where the object is against the gel in frame `last`, (224, 224).
        last: The later frame.
    """
    count = contact.sum()
    if count == 0:
        return 0.0, 0.0
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
    return float(abs(turn) * gyration), float(np.hypot(moved_x, moved_y))


def image_change(
    first: NDArray[np.float32], last: NDArray[np.float32], touches: NDArray[np.bool_]
) -> float:
    """Return the RMS difference of two planar images over `touches`, 0 where nothing touches."""
    if not touches.any():
        return 0.0
    square = np.square(last - first).sum(axis=0)
    return float(np.sqrt(square[touches].mean() / len(first)))


def patch_means(images: NDArray[np.generic]) -> NDArray[np.float32]:
    """Return the mean of every patch: (frames, 224, 224) to (frames, 14, 14)."""
    blocks = images.reshape(-1, GRID_SIDE, PATCH_SIDE, GRID_SIDE, PATCH_SIDE)
    return blocks.mean(axis=(2, 4), dtype=np.float32)


def patch_displacement(scene: Scene, contact: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return how far the object's point now under each patch centre has come since frame 0.

    Args:
        scene: Poses and pixel sizes.
        contact: Share of every patch in contact, (frames, 14, 14).

    Returns:
        float32 (frames, 14, 14, 2), pixels of the 224-pixel image, (x right, y down); zero where a
        patch is not in contact.
    """
    path, optics = scene.path, scene.optics
    centres = (np.arange(GRID_SIDE) + 0.5) * PATCH_SIDE - IMAGE_SIDE / 2
    x, y = np.meshgrid(centres * optics.mm_per_px_x, centres * optics.mm_per_px_y)
    moved = np.zeros((len(path), GRID_SIDE, GRID_SIDE, 2), np.float32)
    for frame in range(len(path)):
        turn = path.rotation_rad[frame] - path.rotation_rad[0]
        cos, sin = np.cos(turn), np.sin(turn)
        from_x, from_y = x - path.x_mm[frame], y - path.y_mm[frame]
        # The point stood at c0 + R(-turn)(X - c): turn back, then put the object's centre back.
        moved[frame, ..., 0] = x - (path.x_mm[0] + cos * from_x + sin * from_y)
        moved[frame, ..., 1] = y - (path.y_mm[0] - sin * from_x + cos * from_y)
    moved /= np.array([optics.mm_per_px_x, optics.mm_per_px_y], np.float32)
    return np.where(contact[..., None] > 0, moved, 0).astype(np.float32)
