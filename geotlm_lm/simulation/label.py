"""The truth about a clip: its label, and the object's motion patch by patch; draws no picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import GRID_SIDE, IMAGE_SIDE, PATCH_SIDE
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist, counts
from geotlm_lm.simulation.scene import Scene
from geotlm_lm.simulation.trace import READABLE_GREY, Trace

READABLE_CONTACT = 0.005
"""Share of the view that must be in contact for a motion to be read at all: one patch of 14x14."""


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
        is_readable=is_readable(scene.motion, contact_fraction, trace, scene.dominance),
        mm_per_px=(scene.optics.mm_per_px_x, scene.optics.mm_per_px_y),
        travel_px=trace.travel_px,
        radius_px=trace.radius_px,
        visible_grey=trace.visible_grey,
    )


def twist_of(label: MotionLabel) -> Twist:
    """Return the motion with all its components that a simulated clip's label tells.

    Raises:
        ValueError: If the label does not tell the travel of the contact, as recordings' do not.
    """
    if label.travel_px is None:
        raise ValueError("a label without the travel of the contact tells no twist")
    return Twist(label.rotation_deg, *label.travel_px, label.depth_change_mm)


@dataclass(frozen=True)
class ComponentTruth:
    """What is true of one component of a clip's motion.

    Args:
        way: Name nearest to its direction.
        counts: Whether it counts; None where that is ambiguous.
        is_visible: Whether it alone can have changed the picture by more than noise does.
    """

    way: Motion
    counts: bool | None
    is_visible: bool


def components_of(label: MotionLabel) -> dict[Component, ComponentTruth]:
    """Return what a simulated clip's label tells of each component."""
    twist = twist_of(label)
    return {
        component: ComponentTruth(
            twist.way(component),
            counts(component, twist.path(component, label.radius_px)),
            grey >= READABLE_GREY,
        )
        for component, grey in zip(COMPONENTS, label.visible_grey, strict=True)
    }


def is_readable(
    motion: Motion, contact_fraction: NDArray[np.floating], trace: Trace, dominance: float = 1.0
) -> bool:
    """Tell whether the frames show the motion; stillness and absence always can be seen."""
    if motion in (Motion.STILL, Motion.NONE):
        return True
    touched = contact_fraction if motion in DIRECTED else [np.max(contact_fraction)]
    return bool(np.min(touched) >= READABLE_CONTACT and trace.shows(motion, dominance))


def patch_means(images: NDArray[np.generic]) -> NDArray[np.float32]:
    """Return the mean of every patch: (frames, 224, 224) to (frames, 14, 14)."""
    # Whole pixels per patch: the area means are plain means, ten times faster than numpy's.
    grid = (GRID_SIDE, GRID_SIDE)
    images = images.astype(np.float32, copy=False)
    return np.stack([cv2.resize(image, grid, interpolation=cv2.INTER_AREA) for image in images])


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
    x, y = centres * optics.mm_per_px_x, centres[:, None] * optics.mm_per_px_y
    turn, at_x, at_y = (
        np.array(values)[:, None, None] for values in (path.rotation_rad, path.x_mm, path.y_mm)
    )
    cos, sin = np.cos(turn - turn[0]), np.sin(turn - turn[0])
    from_x, from_y = x - at_x, y - at_y
    # The point stood at c0 + R(-turn)(X - c): turn back, then put the object's centre back.
    moved = np.empty((len(path), GRID_SIDE, GRID_SIDE, 2), np.float32)
    moved[..., 0] = x - (at_x[0] + cos * from_x + sin * from_y)
    moved[..., 1] = y - (at_y[0] - sin * from_x + cos * from_y)
    moved /= np.array([optics.mm_per_px_x, optics.mm_per_px_y], np.float32)
    moved[contact == 0] = 0
    return moved
