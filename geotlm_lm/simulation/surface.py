"""Contact solution to the gel's surface at image resolution; knows no light and no label."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.contact import BOX_MM, dome_mm, solve_contact
from geotlm_lm.simulation.normal_contact import SolverStatus
from geotlm_lm.simulation.presets import FAST, Preset
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import Scene

TOUCH_TOLERANCE_MM = 0.020
"""Gap that still counts as contact at image resolution: with it the touched area of nine bodies is
0.71 to 1.47 (median 0.96) of a five times finer grid's, measured."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The gel's surface in every frame.

    Args:
        indentation_mm: float32 (frames, 224, 224); smoothed by the coat where nothing touches, and
            late to rise where the gel lags.
        touches: bool (frames, 224, 224), where the object is against the gel.
        drift_mm: Tangential displacement of the surface from rest, float32 (frames, 2, 224, 224), x
            before y; None where it was not asked for.
        status: The solver's account.
    """

    indentation_mm: NDArray[np.float32]
    touches: NDArray[np.bool_]
    drift_mm: NDArray[np.float32] | None
    status: SolverStatus


def pressed_surface(
    scene: Scene, profile: Profile, preset: Preset = FAST, *, with_drift: bool = False
) -> Surface:
    """Return the gel's surface under `profile` in every frame of `scene`.

    Args:
        scene: Gel, path and pixel sizes.
        profile: The body.
        preset: How finely and tightly the contact is solved.
        with_drift: Whether the tangential displacement is wanted; an image without markers does
            not need it.
    """
    path, optics = scene.path, scene.optics
    contact = solve_contact(scene, profile, preset, with_drift=with_drift)
    mm_per_px = (optics.mm_per_px_x, optics.mm_per_px_y)
    dome = dome_mm(scene.gel, mm_per_px, IMAGE_SIDE, optics.mounting)
    cells = contact.indentation_mm.shape[-1]
    rows, columns = (_cubic_weights(size, cells) for size in mm_per_px[::-1])
    solved = contact.indentation_mm.float()
    fine = (rows @ solved @ columns.T).numpy()
    smooth = fine
    if scene.gel.membrane_mm > 0:
        coat = _gaussian(scene.gel.membrane_mm, cells)
        smooth = ((rows @ coat) @ solved @ (columns @ coat).T).numpy()
    drift = None
    if contact.drift_mm is not None:
        drift = (rows @ contact.drift_mm.float() @ columns.T).numpy()
    indentation = np.zeros((len(path), IMAGE_SIDE, IMAGE_SIDE), np.float32)
    touches = np.zeros(indentation.shape, bool)
    poses = list(zip(path.x_mm, path.y_mm, path.rotation_rad, strict=True))
    for frame in np.flatnonzero(contact.touches.numpy()):
        elastic = fine[frame]
        rigid = profile.sample(poses[frame], mm_per_px, IMAGE_SIDE)
        np.subtract(np.float32(path.depth_mm[frame]) - dome, rigid, out=rigid)
        # Detail finer than a cell prints through wherever the object reaches below the solution.
        touches[frame] = rigid > elastic - np.float32(TOUCH_TOLERANCE_MM)
        np.maximum(smooth[frame], rigid, out=indentation[frame])
    if scene.gel.lag > 0:
        _creep(indentation, scene.gel.lag)
    return Surface(indentation, touches, drift, contact.status)


def _creep(indentation_mm: NDArray[np.float32], lag: float) -> None:
    """Let the gel rise late: a share of what a frame lacks of the one before is still there."""
    for before, now in zip(indentation_mm[:-1], indentation_mm[1:], strict=True):
        lacks = np.maximum(before - now, 0)
        lacks *= np.float32(lag)
        now += lacks


def _gaussian(sigma_mm: float, cells: int) -> torch.Tensor:
    """Return weights (cells, cells) of a periodic Gaussian; it keeps a volume exactly.

    On the contact grid: what is narrower than a third of a cell (0.18 mm with the fast preset)
    smooths nothing.
    """
    away = np.arange(cells)
    away = np.minimum(away, cells - away) * BOX_MM / cells
    line = np.exp(-0.5 * (away / sigma_mm) ** 2)
    line /= line.sum()
    index = (np.arange(cells)[:, None] - np.arange(cells)) % cells
    return torch.from_numpy(line[index].astype(np.float32))


def _cubic_weights(mm_per_px: float, cells: int) -> torch.Tensor:
    """Return weights (224, cells) of cubic convolution (Keys, a = -1/2) from cells to pixels."""
    where = (np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2) * mm_per_px * cells / BOX_MM
    where = where + (cells - 1) / 2
    left = np.floor(where).astype(int)
    weights = np.zeros((IMAGE_SIDE, cells), np.float32)
    for offset in range(-1, 3):
        s = np.abs(where - left - offset)
        near = 1.5 * s**3 - 2.5 * s**2 + 1
        far = -0.5 * s**3 + 2.5 * s**2 - 4 * s + 2
        values = np.where(s <= 1, near, np.where(s < 2, far, 0))
        weights[np.arange(IMAGE_SIDE), (left + offset) % cells] += values
    return torch.from_numpy(weights)
