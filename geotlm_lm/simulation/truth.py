"""The truth about a clip: its label, the object's motion patch by patch, and what shows of it.

A motion shows by how much it changes noise-free frames, or the shading of the surface alone. How
well a picture holds each component is told by the Gauss-Newton matrix of its change: the body alone
is moved by a little each way, under a gel and lights that stay; what the shading of the overlap
changes by is one column of the Jacobian. What no other component could have changed is what shows
of a component: nothing of an edge's travel along itself, nothing of a smooth ball's turn, whatever
outline the domed pad gives the contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import GRID_SIDE, IMAGE_SIDE, PATCH_SIDE
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.twist import BARELY_MM, BARELY_PX, COMPONENTS, Component, Twist, moves
from geotlm_lm.simulation.contact import dome_mm
from geotlm_lm.simulation.optics import turned_lights
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import Optics, Scene

Floats = NDArray[np.float32]

READABLE_CONTACT = 0.005
"""Share of the view that must be in contact for a motion to be read at all: one patch of 14x14."""

READABLE_GREY = 2.0
"""RMS change of the noise-free image over the contact, in grey levels, below which a motion drowns:
one frame's noise has a standard deviation of 1.2 to 2.0 grey levels, measured."""

SHADED_SIDE = 112
"""Side of the images that are shaded: detail of two pixels of the camera's is blurred anyway."""

STEP_PX, STEP_MM = 1.0, 0.05
"""How far the body is moved, of the 224-pixel image along the gel and into it."""

LEAST_OVERLAP_PX = 12
"""Touched pixels below which nothing is seen."""


@dataclass(frozen=True)
class Trace:
    """What there is to see of a motion between the first frame and a later one."""

    change_grey: float = 0.0  # RMS of the noise-free image over the contact
    turn_mm: float = 0.0  # path by turning, at the contact's radius of gyration
    slide_mm: float = 0.0  # travel at the contact's centre
    travel_px: tuple[float, float] = (0.0, 0.0)  # the same right and down, of the 224-pixel image
    radius_px: float = 0.0  # of gyration
    visible_grey: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of `visible_change`

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
    profile: Profile,
    change_until: Callable[[int], float],
    touches: NDArray[np.bool_],
    last: int,
) -> Trace:
    """Return what there is to see between frame 0 and frame `last`.

    The change of the picture over the contact since frame 0, in grey levels, is asked for by frame
    number. `touches` is where the object is against the gel, (frames, 224, 224).
    """
    frame = last if touches[last].any() else 0
    if last == 0 or not touches[frame].any():
        return Trace()
    contact = contact_of(scene, touches[frame])
    x, y, turn_rad = motion_at_contact(scene, contact.middle_mm, last)
    travel_px = x / scene.optics.mm_per_px_x, y / scene.optics.mm_per_px_y
    inward_mm = scene.path.depth_mm[last] - scene.path.depth_mm[0]
    twist = Twist(math.degrees(turn_rad), *travel_px, inward_mm)
    return Trace(
        change_grey=change_until(last),
        turn_mm=abs(turn_rad) * contact.radius_mm,
        slide_mm=float(np.hypot(x, y)),
        travel_px=travel_px,
        radius_px=contact.radius_px,
        visible_grey=visible_change(scene, profile, frame, contact, twist),
    )


@dataclass(frozen=True)
class Contact:
    """Where the object touches: the middle, and the radius of gyration about it."""

    middle_mm: tuple[float, float]
    radius_mm: float
    radius_px: float


def contact_of(scene: Scene, touches: NDArray[np.bool_]) -> Contact:
    """Return the contact of one frame, where `touches` (224, 224) is true somewhere."""
    optics, axis = scene.optics, np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2
    x, by_column = axis * optics.mm_per_px_x, touches.mean(axis=0, dtype=np.float32)
    y, by_row = axis * optics.mm_per_px_y, touches.mean(axis=1, dtype=np.float32)
    by_column, by_row = by_column / by_column.sum(), by_row / by_row.sum()
    middle_x, middle_y = float(by_column @ x), float(by_row @ y)
    across, down = by_column @ (x - middle_x) ** 2, by_row @ (y - middle_y) ** 2
    in_px = across / optics.mm_per_px_x**2 + down / optics.mm_per_px_y**2
    return Contact((middle_x, middle_y), float(np.sqrt(across + down)), float(np.sqrt(in_px)))


def shading_change(
    optics: Optics, first_mm: Floats, last_mm: Floats, where: NDArray[np.bool_]
) -> float:
    """Return about what `image_change` would, from two surfaces alone, without any picture.

    The lights' shading of the indentation (224, 224), softened on steep slopes, on a gel of the
    measured mean grey level; uneven light, shadows, blur and specks are left out.
    """
    if not where.any():
        return 0.0
    change = 0.0
    for sign, depth in ((1, last_mm), (-1, first_mm)):
        slopes = [
            -cv2.Sobel(depth, cv2.CV_32F, *axis, ksize=3, scale=0.125 / size)[where]
            for axis, size in (((1, 0), optics.mm_per_px_x), ((0, 1), optics.mm_per_px_y))
        ]
        steep = np.square(slopes).sum(axis=0)
        soft = np.stack(slopes) / np.sqrt(1 + optics.saturation**2 * steep)
        shade = turned_lights(optics) @ soft + np.outer(optics.depth_gain, depth[where])
        change = change + sign * (shade - 2 * optics.steep_darkening * steep / (1 + steep))
    return float(np.sqrt(np.square(optics.lamps.mean_grey[:, None] * change).mean()))


def motion_at_contact(
    scene: Scene, middle_mm: tuple[float, float], last: int
) -> tuple[float, float, float]:
    """Return travel right and down in mm and turn in rad, clockwise positive, since frame 0.

    The travel is that of the object's point that lies in the middle of the contact in frame `last`.
    """
    path, (middle_x, middle_y) = scene.path, middle_mm
    turn = path.rotation_rad[last] - path.rotation_rad[0]
    # The point now at the middle stood at c0 + R(-turn)(middle - c).
    from_x, from_y = middle_x - path.x_mm[last], middle_y - path.y_mm[last]
    moved_x = middle_x - (path.x_mm[0] + np.cos(turn) * from_x + np.sin(turn) * from_y)
    moved_y = middle_y - (path.y_mm[0] - np.sin(turn) * from_x + np.cos(turn) * from_y)
    return float(moved_x), float(moved_y), float(turn)


def image_change(first: Floats, last: Floats, where: NDArray[np.bool_]) -> float:
    """Return the RMS difference of two planar images over `where`, 0 where that is nowhere."""
    if not where.any():
        return 0.0
    mask = where.view(np.uint8)
    # Norms under a mask cost a sixth of picking the pixels out.
    pairs = zip(first, last, strict=True)
    squares = sum(cv2.norm(*planes, cv2.NORM_L2SQR, mask) for planes in pairs)
    return float(np.sqrt(squares / (len(first) * np.count_nonzero(where))))


def label_for(
    scene: Scene, contact_fraction: NDArray[np.floating], trace: Trace, last: int = -1
) -> MotionLabel:
    """Return the label of a clip from its first frame to its frame `last`.

    The share of the view in contact is one number per labelled frame; the trace is of these frames.
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
        mm_per_px=scene.optics.mm_per_px,
        travel_px=trace.travel_px,
        radius_px=trace.radius_px,
        visible_grey=trace.visible_grey,
    )


def twist_of(label: MotionLabel) -> Twist:
    """Return the motion with all its components; recordings' labels hold none: a ValueError."""
    if label.travel_px is None:
        raise ValueError("a label without the travel of the contact tells no twist")
    return Twist(label.rotation_deg, *label.travel_px, label.depth_change_mm)


@dataclass(frozen=True)
class ComponentTruth:
    """What is true of one component of a clip's motion."""

    way: Motion  # nearest to its direction
    moves: bool | None  # None where that is too little to be graded
    # It alone can have changed the picture by more than noise does, or would have, were it so long
    # that it no longer moves barely.
    is_visible: bool


def components_of(label: MotionLabel) -> dict[Component, ComponentTruth]:
    """Return what is true of each component by a simulated clip's label."""
    twist, parts = twist_of(label), {}
    for component, grey in zip(COMPONENTS, label.visible_grey, strict=True):
        path = twist.path(component, label.radius_px)
        least = BARELY_MM if component is Component.PRESS else BARELY_PX
        is_visible = grey >= READABLE_GREY * min(path / least, 1.0)
        parts[component] = ComponentTruth(twist.way(component), moves(component, path), is_visible)
    return parts


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

    float32 (frames, 14, 14, 2), pixels of the 224-pixel image, (x right, y down); zero where the
    share of a patch in contact, (frames, 14, 14), is zero.
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


def visible_change(
    scene: Scene, profile: Profile, frame: int, contact: Contact, twist: Twist
) -> tuple[float, float, float]:
    """Return how much of the picture's change only turn, slide and press can have made.

    RMS over the contact of each component's change, less what the other components could explain,
    in grey levels; of a slide along the axis that is seen least.
    """
    radius_px = contact.radius_px
    shading = _shading_of(scene, profile, frame, contact.middle_mm)
    base, overlap = shading(0.0, 0.0, 0.0, 0.0)
    where = overlap > 0
    if np.count_nonzero(where) < LEAST_OVERLAP_PX:
        return 0.0, 0.0, 0.0
    wide, high = scene.optics.mm_per_px_x, scene.optics.mm_per_px_y
    turn = STEP_PX / max(radius_px, 1.0)
    moves = (
        (turn, 0, 0, 0),
        (0, STEP_PX * wide, 0, 0),
        (0, 0, STEP_PX * high, 0),
        (0, 0, 0, STEP_MM),
    )
    columns = []
    for move in moves:
        moved, overlap = shading(*move)
        where = where | (overlap > 0)
        columns.append(moved - base)
    jacobian = np.stack([column[:, where].ravel() for column in columns]).astype(np.float64)
    normal = jacobian @ jacobian.T / jacobian.shape[1]
    covariance = np.linalg.inv(normal + 1e-6 * np.eye(4))
    turned_px = np.radians(abs(twist.turn_deg)) * radius_px
    steps = turned_px / STEP_PX, twist.slide_px / STEP_PX, abs(twist.inward_mm) / STEP_MM
    worst = float(np.linalg.eigvalsh(covariance[1:3, 1:3])[-1])
    variances = (covariance[0, 0], worst, covariance[3, 3])
    return tuple(
        float(step / np.sqrt(variance)) for step, variance in zip(steps, variances, strict=True)
    )


def _shading_of(
    scene: Scene, profile: Profile, frame: int, centre_mm: tuple[float, float]
) -> Callable[[float, float, float, float], tuple[Floats, Floats]]:
    """Return what shades a body that is moved a little from one frame's pose.

    Turn about the contact's middle in rad, travel right, down and into the gel in mm -> change of
    the picture from the idle gel in grey levels (3, side, side), and the overlap (side, side).
    """
    optics, path, side = scene.optics, scene.path, SHADED_SIDE
    scale = IMAGE_SIDE / side
    pixel = (optics.mm_per_px_x * scale, optics.mm_per_px_y * scale)
    level = np.float32(path.depth_mm[frame]) - dome_mm(scene.gel, pixel, side, optics.mounting)
    lights, (centre_x, centre_y) = turned_lights(optics), centre_mm
    # Under light from all around only steepness and depth show.
    loss = 0.0 if optics.lamps.is_directional else 2 * optics.steep_darkening
    from_x, from_y = path.x_mm[frame] - centre_x, path.y_mm[frame] - centre_y

    def shading(turn_rad, x_mm, y_mm, inward_mm):
        cos, sin = np.cos(turn_rad), np.sin(turn_rad)
        pose = (
            centre_x + cos * from_x - sin * from_y + x_mm,
            centre_y + sin * from_x + cos * from_y + y_mm,
            path.rotation_rad[frame] + turn_rad,
        )
        overlap = level + np.float32(inward_mm) - profile.sample(pose, pixel, side)
        overlap = cv2.GaussianBlur(cv2.max(overlap, 0), (0, 0), 0.8)
        slopes = [
            cv2.Sobel(overlap, cv2.CV_32F, *axis, ksize=3, scale=-0.125 / size)
            for axis, size in (((1, 0), pixel[0]), ((0, 1), pixel[1]))
        ]
        steep = slopes[0] ** 2 + slopes[1] ** 2
        soft = np.sqrt(1 + optics.saturation**2 * steep)
        planes = [
            grey * ((right * slopes[0] + down * slopes[1]) / soft + gain * overlap)
            for grey, (right, down), gain in zip(
                optics.lamps.mean_grey, lights, optics.depth_gain, strict=True
            )
        ]
        if loss:
            planes -= np.multiply.outer(optics.lamps.mean_grey, loss * steep / (1 + steep))
        return np.stack(planes).astype(np.float32), overlap

    return shading
