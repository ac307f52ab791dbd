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
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.twist import BARELY_MM, BARELY_PX, COMPONENTS, Component, Twist, moves
from geotlm_lm.simulation.contact import dome_mm
from geotlm_lm.simulation.optics import slopes_of, turned_lights
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import Optics, Path, Scene
from geotlm_lm.simulation.surface import Surface

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


def trace_of(
    scene: Scene, profile: Profile, surface: Surface | None, clean: list[Floats] | None, last: int
) -> Trace:
    """Return what there is to see between frame 0 and frame `last`.

    Without a surface nothing touches. `clean` are planar frames without noise; without any the
    change of the picture is estimated from the surface.
    """
    if surface is None or last == 0:
        return Trace()
    touches, depths = surface.touches, surface.indentation_mm
    frame = last if touches[last].any() else 0
    if not touches[frame].any():
        return Trace()
    where = touches[0] | touches[last]
    if clean is None:
        change_grey = shading_change(scene.optics, depths[0], depths[last], where)
    else:
        change_grey = image_change(clean[0], clean[last], where)
    contact = contact_of(scene, touches[frame])
    x, y, turn_rad = motion_at_contact(scene, contact.middle_mm, last)
    travel_px = x / scene.optics.mm_per_px_x, y / scene.optics.mm_per_px_y
    twist = Twist(math.degrees(turn_rad), *travel_px, scene.path.change(last)[0])
    return Trace(
        change_grey=change_grey,
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
        slopes = [slope[where] for slope in slopes_of(depth, optics.mm_per_px)]
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
    x, y = _moved(scene.path, last, *middle_mm)
    return float(x), float(y), scene.path.change(last)[3]


def _moved(path: Path, frame: int, x_mm, y_mm):
    """Return how far the object's point now at (x, y) has come since frame 0, right and down."""
    turn = path.rotation_rad[frame] - path.rotation_rad[0]
    cos, sin = np.cos(turn), np.sin(turn)
    from_x, from_y = x_mm - path.x_mm[frame], y_mm - path.y_mm[frame]
    # It stood at c0 + R(-turn)(X - c): turn back, then put the object's centre back.
    right = x_mm - (path.x_mm[0] + cos * from_x + sin * from_y)
    return right, y_mm - (path.y_mm[0] - sin * from_x + cos * from_y)


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
    inward_mm, right_mm, down_mm, turn_rad = scene.path.change(last)
    return MotionLabel(
        motion=scene.motion,
        rotation_deg=float(np.degrees(turn_rad)),
        slide_x_mm=right_mm,
        slide_y_mm=down_mm,
        depth_change_mm=inward_mm,
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
    """Tell whether the frames show the motion; stillness and absence always can be seen.

    A turn about an axis far beside the contact carries the contact along farther than it turns it:
    its picture is a slide's, whatever the hand did. So the named path has to be `dominance` times
    the other one.
    """
    if motion in (Motion.STILL, Motion.NONE):
        return True
    touched, own, lesser = np.min(contact_fraction), trace.slide_mm, trace.turn_mm
    if motion in ROTATIONS:
        own, lesser = lesser, own
    elif motion not in SLIDES:
        touched, own, lesser = np.max(contact_fraction), 0.0, 0.0
    is_seen = touched >= READABLE_CONTACT and trace.change_grey >= READABLE_GREY
    return bool(is_seen and own >= dominance * lesser)


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
    path, (wide, high) = scene.path, scene.optics.mm_per_px
    centres = (np.arange(GRID_SIDE) + 0.5) * PATCH_SIDE - IMAGE_SIDE / 2
    moved = np.empty((len(path), GRID_SIDE, GRID_SIDE, 2), np.float32)
    for frame, field in enumerate(moved):
        field[..., 0], field[..., 1] = _moved(path, frame, centres * wide, centres[:, None] * high)
    moved /= np.array([wide, high], np.float32)
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
    loss = 0.0 if np.any(optics.lamps.rows) else 2 * optics.steep_darkening
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
        slopes = slopes_of(overlap, pixel)
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
