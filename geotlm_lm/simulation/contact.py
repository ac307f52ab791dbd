"""A scene's contact on the gel's grid, frame by frame: pressed only, or dragged with history.

A residual that is too large is answered by the next harder preset, and the result says so; what
even the hardest does not solve is never called converged.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.simulation.elastic import LayerOperator
from geotlm_lm.simulation.half_space import HalfSpaceOperator
from geotlm_lm.simulation.march import Increment, Step, cell_centres, march, rigid_travel
from geotlm_lm.simulation.normal_contact import (
    Response,
    SolverStatus,
    solve_normal_contact,
)
from geotlm_lm.simulation.presets import Preset
from geotlm_lm.simulation.profile import HeightMap, Profile
from geotlm_lm.simulation.scene import Gel, Mounting, Path, Scene

BOX_MM = 25.6
"""Side of the periodic box; doubling it changes the indentation by at most 2.7 um, measured."""

DOME_RADII_MM = (188.0, 114.0)
"""Radii of the pad's crown along x and y: 0.25 mm sag at 9.7 and 7.5 mm (FEATS CAD model)."""

TURN_STEP_RAD = np.radians(3.0)
TRAVEL_STEP_MM = 0.3
"""Farthest an object goes in one increment, along the gel or into it: the error of a step grows in
proportion (measured)."""

REACH_PER_DEPTH = 1.4
LEAST_REACH_MM = 0.05
"""Height of the body that is looked at, per depth and at least: around a contact the gel bulges up
by at most 0.3 of the depth on a pad as thick as a GelSight's (measured)."""

LEAST_WORK = 1e-9
"""Work, in mm^3 per shear modulus, of which no share is told: rounding."""

Pose = tuple[float, float, float, float]
"""Depth in mm, x and y in mm, rotation in radians."""


@dataclass(frozen=True, eq=False)
class GridContact:
    """The gel on the contact grid in every frame.

    Args:
        indentation_mm: (frames, cells, cells).
        drift_mm: Tangential displacement of the surface from rest, (frames, 2, cells, cells); None
            where it was not asked for.
        touches: Whether anything presses in a frame, (frames,).
        overlap_mm: Approach less the body's profile and the pad's crown, (frames, cells, cells).
        reach_mm: Height of the body above its lowest point that the gel does not reach.
        status: The solver's account.
    """

    indentation_mm: Tensor
    drift_mm: Tensor | None
    touches: Tensor
    overlap_mm: Tensor
    reach_mm: float
    status: SolverStatus


def solve_contact(
    scene: Scene, profile: Profile, preset: Preset, *, with_drift: bool = False
) -> GridContact:
    """Solve every frame of a scene; escalates until the residuals are acceptable.

    Args:
        scene: Gel and path.
        profile: The body.
        preset: Where to begin.
        with_drift: Whether the surface's tangential displacement is wanted. Without friction it is
            what the pressure spreads; with it the object holds the gel, in a press too.
    """
    drags = with_drift and scene.gel.friction > 0
    trying: Preset | None = preset
    deepest = max(scene.path.depth_mm)
    reach = REACH_PER_DEPTH * max(deepest, 0.0) + LEAST_REACH_MM
    while trying is not None:
        if drags:
            solved = _dragged(scene, profile, trying, reach)
        else:
            solved = _pressed(scene, profile, trying, with_drift, reach)
        if reach < np.inf and float(solved.indentation_mm.min()) < deepest - reach:
            # The gel bulges higher than the body was looked at: thin incompressible layers do.
            reach = np.inf
            continue
        solved = replace(solved, status=replace(solved.status, preset=trying.name))
        if solved.status.is_converged:
            break
        trying = trying.harder
    return solved


def _pressed(
    scene: Scene, profile: Profile, preset: Preset, with_drift: bool, reach: float
) -> GridContact:
    """Solve all frames at once, without friction: each depends on its own pose only."""
    overlap = _overlap(scene, profile, preset, list(_poses(scene.path)), reach)
    response = _layer(scene.gel, preset)
    contact = solve_normal_contact(
        overlap,
        response,
        rounds=preset.effort.normal_rounds,
        limit_um=preset.effort.penetration_um,
        enough_um=preset.effort.enough_um,
    )
    status = contact.status()
    status = replace(status, is_converged=status.penetration_um <= preset.acceptable_um)
    drift = response.spread(contact.pressure) if with_drift else None
    touches = contact.touches.flatten(1).any(1)
    return GridContact(contact.indentation_mm, drift, touches, overlap, reach, status)


def _dragged(scene: Scene, profile: Profile, preset: Preset, reach: float) -> GridContact:
    """March through the frames with friction and history."""
    response = _layer(scene.gel, preset)
    poses = list(_poses(scene.path))
    substeps = list(_substeps(poses, preset.step_share, _before(scene.path)))
    starts = [substeps[0][0], *(pose for pose, _ in substeps[:-1])]
    increments = [
        _increment(scene, profile, preset, before, after, reach)
        for before, (after, _) in zip(starts, substeps, strict=True)
    ]
    steps = march(
        increments, response, friction_coefficient=scene.gel.friction, effort=preset.effort
    )
    kept: list[Step] = []
    overlaps: list[Tensor] = []
    worst = SolverStatus(0.0, 0, True)
    spent = rubbed = energy = 0.0
    for step, increment, (_, ends_frame) in zip(steps, increments, substeps, strict=True):
        rubbed += float(step.work) - (float(step.energy) - energy)
        spent, energy = spent + max(float(step.work), 0.0), float(step.energy)
        worst = _worse(worst, step, scene.gel.friction, preset)
        if ends_frame:
            kept.append(step)
            overlaps.append(increment.overlap_mm)
    worst = replace(worst, increments=len(increments))
    return GridContact(
        torch.cat([step.indentation_mm for step in kept]),
        torch.cat([step.drift_mm for step in kept]),
        torch.cat([(step.pressure > 0).flatten(1).any(1) for step in kept]),
        torch.cat(overlaps),
        reach,
        replace(worst, dissipated_share=rubbed / spent if spent > LEAST_WORK else 0.0),
    )


def _worse(status: SolverStatus, step: Step, friction: float, preset: Preset) -> SolverStatus:
    # numpy's maximum keeps a NaN, so that no solution that is not finite counts as converged.
    penetration = float(np.maximum(status.penetration_um, float(step.penetration_um)))
    gradient = float(np.maximum(status.gradient_share, float(step.gradient_share)))
    limit = friction * step.pressure
    excess = (step.traction.norm(dim=1) - limit).amax() / limit.amax().clamp_min(1e-12)
    return replace(
        status,
        penetration_um=penetration,
        gradient_share=gradient,
        cone_excess=max(status.cone_excess, float(excess)),
        iterations=max(status.iterations, step.iterations[0]),
        friction_iterations=max(status.friction_iterations, step.iterations[1]),
        is_converged=penetration <= preset.acceptable_um and gradient <= preset.acceptable_share,
    )


def _increment(
    scene: Scene, profile: Profile, preset: Preset, before: Pose, after: Pose, reach: float
) -> Increment:
    centres = cell_centres(preset.cells, BOX_MM / preset.cells, preset.dtype)
    old, new = (torch.tensor([pose[1:3]], dtype=preset.dtype) for pose in (before, after))
    turn = torch.tensor([after[3] - before[3]], dtype=preset.dtype)
    travel = rigid_travel(centres, old, turn, new - old)
    return Increment(_overlap(scene, profile, preset, [after], reach), travel)


def _overlap(
    scene: Scene, profile: Profile, preset: Preset, poses: list[Pose], reach: float
) -> Tensor:
    """Return the approach less the profile and the pad's crown, (poses, cells, cells).

    It is negative all over where a pose is out of touch.
    """
    cells, size = preset.cells, (BOX_MM / preset.cells,) * 2
    dome = dome_mm(scene.gel, size, cells, scene.optics.mounting)
    is_smooth = holds_detail(scene, profile, preset, cells)
    overlap = np.full((len(poses), cells, cells), -1.0, np.float32)
    for one, (depth, *place) in zip(overlap, poses, strict=True):
        if depth > 0:
            height = profile.on_cells(tuple(place), BOX_MM, cells, reach, is_smooth=is_smooth)
            np.subtract(np.float32(depth) - dome, height, out=one)
    return torch.from_numpy(overlap).to(preset.dtype)


def holds_detail(scene: Scene, profile: Profile, preset: Preset, cells: int) -> bool:
    """Tell whether the contact grid holds all there is of the body, as deep as it goes."""
    return preset.skips_fine_profile and profile.is_smooth(BOX_MM / cells, max(scene.path.depth_mm))


def _poses(path: Path) -> Iterator[Pose]:
    return zip(path.depth_mm, path.x_mm, path.y_mm, path.rotation_rad, strict=True)


def _before(path: Path) -> Pose | None:
    """Return the pose from which the object was dragged to the first frame's, if it was."""
    (slide_x, slide_y), turn = path.pre_slide_mm, path.pre_turn_rad
    if not (slide_x or slide_y or turn):
        return None
    depth, x, y, angle = next(_poses(path))
    return depth, x - slide_x, y - slide_y, angle - turn


def _substeps(
    poses: list[Pose], share: float, start: Pose | None = None
) -> Iterator[tuple[Pose, bool]]:
    """Yield the poses to march through, and whether each is a frame's; small steps stay whole."""
    stops = [start, *poses] if start is not None else poses
    yield stops[0], start is None
    for before, after in zip(stops[:-1], stops[1:], strict=True):
        travel = max(
            np.hypot(after[1] - before[1], after[2] - before[2]), abs(after[0] - before[0])
        )
        turn = abs(after[3] - before[3])
        steps = max(turn / TURN_STEP_RAD, travel / TRAVEL_STEP_MM) / share
        # Rounding must not split a step that is just as long as may be.
        count = max(int(np.ceil(steps - 1e-9)), 1)
        for part in range(1, count + 1):
            along = part / count
            pose = tuple((1 - along) * a + along * b for a, b in zip(before, after, strict=True))
            yield (after if part == count else pose), part == count


def _layer(gel: Gel, preset: Preset) -> Response:
    if preset.is_half_space:
        return HalfSpaceOperator(
            preset.cells, BOX_MM, poisson_ratio=gel.poisson_ratio, dtype=preset.dtype
        )
    return _cached_layer(gel.thickness_mm, gel.poisson_ratio, preset.cells, preset.dtype)


@lru_cache(maxsize=16)
def _cached_layer(
    thickness_mm: float, poisson_ratio: float, cells: int, dtype: torch.dtype
) -> LayerOperator:
    return LayerOperator(
        cells, BOX_MM, thickness_mm=thickness_mm, poisson_ratio=poisson_ratio, dtype=dtype
    )


def dome_drop_mm(gel: Gel, x_mm: float, y_mm: float, mounting: Mounting | None = None) -> float:
    """Return how far the crowned pad lies below its top at one point of the view."""
    xx, xy, yy = _crown(gel, mounting)
    x, y = (x_mm - mounting.x_mm, y_mm - mounting.y_mm) if mounting else (x_mm, y_mm)
    return float(xx * x * x + xy * x * y + yy * y * y)


@lru_cache(maxsize=4)
def dome_mm(
    gel: Gel, mm_per_px: tuple[float, float], side: int, mounting: Mounting | None = None
) -> HeightMap:
    """Return how far the crowned pad lies below its top, (side, side) in mm, read-only."""
    mounting = mounting or Mounting()
    axis = np.arange(side) - (side - 1) / 2
    x, y = axis * mm_per_px[0] - mounting.x_mm, axis * mm_per_px[1] - mounting.y_mm
    xx, xy, yy = _crown(gel, mounting)
    along, across = (values.astype(np.float32) for values in (xx * x * x, yy * y * y))
    drop = np.add.outer(across, along)
    if xy:
        drop += np.multiply.outer((xy * y).astype(np.float32), x.astype(np.float32))
    drop.setflags(write=False)
    return drop


def _crown(gel: Gel, mounting: Mounting | None) -> tuple[float, float, float]:
    """Return the curvatures of the crown in the view: of x^2, x y and y^2, per mm."""
    along, across = (gel.dome / (2 * radius) for radius in DOME_RADII_MM)
    turn = mounting.turn_rad if mounting else 0.0
    cos, sin = np.cos(turn), np.sin(turn)
    return (
        along * cos**2 + across * sin**2,
        2 * (along - across) * cos * sin,
        along * sin**2 + across * cos**2,
    )
