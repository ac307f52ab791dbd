"""A scene's contact on the gel's grid, frame by frame: pressed only, or dragged with history.

Five presets from draft to reference say how finely and tightly it is solved. A residual that is too
large is answered by the next harder preset, and the result says so; what even the hardest does not
solve is never called converged.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.core.errors import UsageError, choice_of
from geotlm_lm.simulation.elastic import HalfSpaceOperator, LayerOperator
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import CENTRED, Gel, Mounting, Path, Scene
from geotlm_lm.simulation.shapes import HeightMap
from geotlm_lm.simulation.solvers import (
    PENETRATION_LIMIT_UM,
    ROUNDS,
    Effort,
    Response,
    SolverStatus,
    Step,
    cell_centres,
    march,
    rigid_travel,
    solve_normal_contact,
)

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

Pose = tuple[float, float, float, float]
"""Depth in mm, x and y in mm, rotation in radians."""

PresetName = Literal["draft", "fast", "good", "accurate", "reference"]


@dataclass(frozen=True)
class Preset:
    """One compromise between error and run time."""

    name: PresetName
    cells: int  # per side of the contact grid, over the pad's 25.6 mm
    effort: Effort
    dtype: torch.dtype = torch.float32  # fields converge to 1e-5 in single precision as in double
    is_half_space: bool = False  # the pad is infinitely thick: for comparison only
    step_share: float = 1.0  # length of an increment relative to the farthest that is small
    # Penetration and projected gradient of friction up to which the result counts as converged.
    acceptable_um: float = PENETRATION_LIMIT_UM
    acceptable_share: float = 0.1

    def response(self, gel: Gel) -> Response:
        """Return the surface's response, made once for each kind of gel."""
        thickness, nu = gel.thickness_mm, gel.poisson_ratio
        return _response(thickness, nu, self.cells, self.dtype, self.is_half_space)

    @property
    def harder(self) -> Preset | None:
        """The next preset up, for the same body and no less precise; None above the reference."""
        names = list(PRESETS)
        above = names[names.index(self.name) + 1 :]
        if not above:
            return None
        return replace(
            PRESETS[above[0]],
            dtype=torch.promote_types(self.dtype, PRESETS[above[0]].dtype),
            is_half_space=self.is_half_space,
            step_share=self.step_share,
        )


PRESETS: dict[str, Preset] = {
    preset.name: preset
    for preset in (
        Preset("draft", 32, Effort((6, 12, 40), 15, 1, 8, enough_um=5.0, gradient_share=0.1)),
        Preset("fast", 48, Effort(ROUNDS, 40, enough_um=5.0, gradient_share=3e-2)),
        Preset("good", 64, Effort((12, 24, 60, 150), 100, gradient_share=1e-2)),
        Preset(
            "accurate",
            128,
            Effort((50, 100, 400), 1000, passes=3, penetration_um=0.1, gradient_share=1e-4),
            torch.float64,
            acceptable_um=1.0,
            acceptable_share=1e-3,
        ),
        Preset(
            "reference",
            256,
            Effort((100, 200, 400, 1000), 1000, penetration_um=0.01, gradient_share=1e-5),
            torch.float64,
            acceptable_um=0.1,
            acceptable_share=1e-4,
        ),
    )
}

FAST = PRESETS["fast"]


def preset_named(name: str) -> Preset:
    """Return the preset called `name`; an unknown name is a `UsageError`."""
    if name not in PRESETS:
        raise UsageError(f"there is no preset '{name}'; {choice_of(name, PRESETS)}")
    return PRESETS[name]


@dataclass(frozen=True, eq=False)
class GridContact:
    """The gel on the contact grid, fields (frames, cells, cells), and the solver's account.

    The drift, (frames, 2, cells, cells), is the surface's tangential displacement from rest; None
    where it was not asked for. `touches` is whether anything presses in a frame; the overlap is the
    approach less the body's profile and the pad's crown; what of the body is more than `reach_mm`
    above its lowest point the gel does not reach.
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
    """Solve every frame of a scene; escalates from `preset` until the residuals are acceptable.

    The surface's tangential displacement, if wanted, is what the pressure spreads without friction;
    with it the object holds the gel, in a press too.
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


def normal_pressure(scene: Scene, profile: Profile, preset: Preset) -> NDArray[np.float64]:
    """Return the first frame's pressure per shear modulus on the contact grid, (cells, cells)."""
    overlap = _overlap(scene, profile, preset, scene.path.poses[:1], np.inf)
    solved = solve_normal_contact(overlap, preset.response(scene.gel), preset.effort)
    return solved.pressure[0].double().numpy()


def _pressed(
    scene: Scene, profile: Profile, preset: Preset, with_drift: bool, reach: float
) -> GridContact:
    """Solve all frames at once, without friction: each depends on its own pose only."""
    overlap = _overlap(scene, profile, preset, scene.path.poses, reach)
    response = preset.response(scene.gel)
    contact = solve_normal_contact(overlap, response, preset.effort)
    worst = float(contact.penetration_um.max())
    status = SolverStatus(worst, worst <= preset.acceptable_um)
    drift = response.spread(contact.pressure) if with_drift else None
    touches = (contact.pressure > 0).flatten(1).any(1)
    return GridContact(contact.indentation_mm, drift, touches, overlap, reach, status)


def _dragged(scene: Scene, profile: Profile, preset: Preset, reach: float) -> GridContact:
    """March through the frames with friction and history."""
    response = preset.response(scene.gel)
    substeps = list(_substeps(scene.path, preset.step_share))
    starts = [substeps[0][0], *(pose for pose, _ in substeps[:-1])]
    increments = [
        _increment(scene, profile, preset, before, after, reach)
        for before, (after, _) in zip(starts, substeps, strict=True)
    ]
    friction = scene.gel.friction
    steps = march(increments, response, preset.effort, friction_coefficient=friction)
    kept: list[Step] = []
    overlaps: list[Tensor] = []
    worst = SolverStatus(0.0, True, increments=len(increments))
    for step, (overlap, _), (_, ends_frame) in zip(steps, increments, substeps, strict=True):
        worst = _worse(worst, step, friction, preset)
        if ends_frame:
            kept.append(step)
            overlaps.append(overlap)
    return GridContact(
        torch.cat([step.indentation_mm for step in kept]),
        torch.cat([step.drift_mm for step in kept]),
        torch.cat([(step.pressure > 0).flatten(1).any(1) for step in kept]),
        torch.cat(overlaps),
        reach,
        worst,
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
        is_converged=penetration <= preset.acceptable_um and gradient <= preset.acceptable_share,
    )


def _increment(
    scene: Scene, profile: Profile, preset: Preset, before: Pose, after: Pose, reach: float
) -> tuple[Tensor, Tensor]:
    """Return overlap and travel, as `march` takes them."""
    centres = cell_centres(preset.cells, BOX_MM / preset.cells, preset.dtype)
    old, new = (torch.tensor([pose[1:3]], dtype=preset.dtype) for pose in (before, after))
    turn = torch.tensor([after[3] - before[3]], dtype=preset.dtype)
    travel = rigid_travel(centres, old, turn, new - old)
    return _overlap(scene, profile, preset, [after], reach), travel


def _overlap(
    scene: Scene, profile: Profile, preset: Preset, poses: list[Pose], reach: float
) -> Tensor:
    """Return the overlap (poses, cells, cells), negative all over where a pose is out of touch."""
    cells, size = preset.cells, (BOX_MM / preset.cells,) * 2
    dome = dome_mm(scene.gel, size, cells, scene.optics.mounting)
    is_smooth = holds_detail(scene, profile, cells)
    overlap = np.full((len(poses), cells, cells), -1.0, np.float32)
    for frame, (depth, *place) in zip(overlap, poses, strict=True):
        if depth > 0:
            height = profile.on_cells(tuple(place), BOX_MM, cells, reach, is_smooth=is_smooth)
            np.subtract(np.float32(depth) - dome, height, out=frame)
    return torch.from_numpy(overlap).to(preset.dtype)


def holds_detail(scene: Scene, profile: Profile, cells: int) -> bool:
    """Tell whether the contact grid holds all there is of the body, as deep as it goes."""
    return profile.is_smooth(BOX_MM / cells, max(scene.path.depth_mm))


def _substeps(path: Path, share: float) -> Iterator[tuple[Pose, bool]]:
    """Yield the poses to march through, and whether each is a frame's; small steps stay whole."""
    poses = path.poses
    (slide_x, slide_y), pre_turn = path.pre_slide_mm, path.pre_turn_rad
    is_handled = bool(slide_x or slide_y or pre_turn)
    if is_handled:  # the object was dragged to the first frame's pose from another
        depth, x, y, angle = poses[0]
        poses.insert(0, (depth, x - slide_x, y - slide_y, angle - pre_turn))
    yield poses[0], not is_handled
    for before, after in pairwise(poses):
        deeper, right, down, turn = (b - a for a, b in zip(before, after, strict=True))
        travel, turn = max(np.hypot(right, down), abs(deeper)), abs(turn)
        steps = max(turn / TURN_STEP_RAD, travel / TRAVEL_STEP_MM) / share
        # Rounding must not split a step that is just as long as may be.
        count = max(int(np.ceil(steps - 1e-9)), 1)
        for part in range(1, count + 1):
            along = part / count
            pose = tuple((1 - along) * a + along * b for a, b in zip(before, after, strict=True))
            yield (after if part == count else pose), part == count


@lru_cache(maxsize=16)
def _response(
    thickness_mm: float, poisson_ratio: float, cells: int, dtype: torch.dtype, is_half_space: bool
) -> Response:
    if is_half_space:
        return HalfSpaceOperator(cells, BOX_MM, poisson_ratio=poisson_ratio, dtype=dtype)
    return LayerOperator(
        cells, BOX_MM, thickness_mm=thickness_mm, poisson_ratio=poisson_ratio, dtype=dtype
    )


def dome_drop_mm(gel: Gel, x_mm: float, y_mm: float, mounting: Mounting = CENTRED) -> float:
    """Return how far the crowned pad lies below its top at one point of the view."""
    xx, xy, yy = _crown(gel, mounting.turn_rad)
    x, y = x_mm - mounting.x_mm, y_mm - mounting.y_mm
    return float(xx * x * x + xy * x * y + yy * y * y)


@lru_cache(maxsize=4)
def dome_mm(
    gel: Gel, mm_per_px: tuple[float, float], side: int, mounting: Mounting = CENTRED
) -> HeightMap:
    """Return how far the crowned pad lies below its top, (side, side) in mm, read-only."""
    axis = np.arange(side) - (side - 1) / 2
    x, y = axis * mm_per_px[0] - mounting.x_mm, axis * mm_per_px[1] - mounting.y_mm
    xx, xy, yy = _crown(gel, mounting.turn_rad)
    along, across = (values.astype(np.float32) for values in (xx * x * x, yy * y * y))
    drop = np.add.outer(across, along)
    if xy:
        drop += np.multiply.outer((xy * y).astype(np.float32), x.astype(np.float32))
    drop.setflags(write=False)
    return drop


def _crown(gel: Gel, turn_rad: float) -> tuple[float, float, float]:
    """Return the curvatures of the crown in the view: of x^2, x y and y^2, per mm."""
    along, across = (gel.dome / (2 * radius) for radius in DOME_RADII_MM)
    cos, sin = np.cos(turn_rad), np.sin(turn_rad)
    return (
        along * cos**2 + across * sin**2,
        2 * (along - across) * cos * sin,
        along * sin**2 + across * cos**2,
    )
