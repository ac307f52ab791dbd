"""Contact solution to the gel's surface at image resolution; knows no light and no label."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.elastic import LayerOperator
from geotlm_lm.simulation.normal_contact import SolverStatus, solve_normal_contact
from geotlm_lm.simulation.profile import HeightMap, Profile
from geotlm_lm.simulation.scene import Gel, Scene

GRID_CELLS = 48
"""Cells per side of the contact grid in the fast setting."""

BOX_MM = 25.6
"""Side of the periodic box; doubling it changes the indentation by at most 2.7 um, measured."""

DOME_RADII_MM = (188.0, 114.0)
"""Radii of the pad's crown along x and y: 0.25 mm sag at 9.7 and 7.5 mm (FEATS CAD model)."""

TOUCH_TOLERANCE_MM = 0.020
"""Gap that still counts as contact at image resolution: with it the touched area of nine bodies is
0.71 to 1.47 (median 0.96) of a five times finer grid's, measured."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The gel's surface in every frame.

    Args:
        indentation_mm: float32 (frames, 224, 224).
        touches: bool (frames, 224, 224), where the object is against the gel.
        status: The solver's account.
    """

    indentation_mm: NDArray[np.float32]
    touches: NDArray[np.bool_]
    status: SolverStatus


def pressed_surface(scene: Scene, profile: Profile) -> Surface:
    """Return the gel's surface under `profile` in every frame of `scene`."""
    path, optics = scene.path, scene.optics
    poses = list(zip(path.x_mm, path.y_mm, path.rotation_rad, strict=True))
    dome = _dome(scene.gel, (BOX_MM / GRID_CELLS,) * 2, GRID_CELLS)
    overlap = np.full((len(path), GRID_CELLS, GRID_CELLS), -1.0, np.float32)
    for frame, (pose, depth) in enumerate(zip(poses, path.depth_mm, strict=True)):
        if depth > 0:
            overlap[frame] = depth - dome - profile.on_cells(pose, BOX_MM, GRID_CELLS)
    response = _layer(scene.gel.thickness_mm, scene.gel.poisson_ratio)
    contact = solve_normal_contact(torch.from_numpy(overlap), response)
    mm_per_px = (optics.mm_per_px_x, optics.mm_per_px_y)
    dome = _dome(scene.gel, mm_per_px, IMAGE_SIDE)
    rows, columns = _cubic_weights(mm_per_px[1]), _cubic_weights(mm_per_px[0])
    fine = (rows @ contact.indentation_mm @ columns.T).numpy()
    indentation = np.zeros((len(path), IMAGE_SIDE, IMAGE_SIDE), np.float32)
    touches = np.zeros(indentation.shape, bool)
    for frame in np.flatnonzero(contact.touches.flatten(1).any(1).numpy()):
        elastic = fine[frame]
        rigid = profile.sample(poses[frame], mm_per_px, IMAGE_SIDE)
        np.subtract(np.float32(path.depth_mm[frame]) - dome, rigid, out=rigid)
        # Detail finer than a cell prints through wherever the object reaches below the solution.
        touches[frame] = rigid > elastic - np.float32(TOUCH_TOLERANCE_MM)
        np.maximum(elastic, rigid, out=indentation[frame])
    return Surface(indentation, touches, contact.status())


@lru_cache(maxsize=64)
def _layer(thickness_mm: float, poisson_ratio: float) -> LayerOperator:
    return LayerOperator(GRID_CELLS, BOX_MM, thickness_mm=thickness_mm, poisson_ratio=poisson_ratio)


def dome_drop_mm(gel: Gel, x_mm: float, y_mm: float) -> float:
    """Return how far the crowned pad lies below its top at one point."""
    return gel.dome * (x_mm**2 / (2 * DOME_RADII_MM[0]) + y_mm**2 / (2 * DOME_RADII_MM[1]))


def _dome(gel: Gel, mm_per_px: tuple[float, float], side: int) -> HeightMap:
    """Return how far the crowned pad lies below its top, (side, side) in mm."""
    axis = np.arange(side) - (side - 1) / 2
    x = (axis * mm_per_px[0]) ** 2 * gel.dome / (2 * DOME_RADII_MM[0])
    y = (axis * mm_per_px[1]) ** 2 * gel.dome / (2 * DOME_RADII_MM[1])
    return (x[None, :] + y[:, None]).astype(np.float32)


def _cubic_weights(mm_per_px: float) -> torch.Tensor:
    """Return weights (224, 48) of cubic convolution (Keys, a = -1/2) from cells to pixels."""
    cell = BOX_MM / GRID_CELLS
    where = (np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2) * mm_per_px / cell
    where = where + (GRID_CELLS - 1) / 2
    left = np.floor(where).astype(int)
    weights = np.zeros((IMAGE_SIDE, GRID_CELLS), np.float32)
    for offset in range(-1, 3):
        s = np.abs(where - left - offset)
        near = 1.5 * s**3 - 2.5 * s**2 + 1
        far = -0.5 * s**3 + 2.5 * s**2 - 4 * s + 2
        values = np.where(s <= 1, near, np.where(s < 2, far, 0))
        np.add.at(weights, (np.arange(IMAGE_SIDE), (left + offset) % GRID_CELLS), values)
    return torch.from_numpy(weights)
