"""The turn and the slide that fit a displacement field, and how far its weight reaches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float32]

MISFIT_FLOOR = 1e-6
"""Squared px; keeps a perfect fit from dividing by zero."""


def fit_rigid(
    field: Field,
    weight: Field,
    reweightings: int = 0,
    grid_px: float | tuple[float, float] = 1.0,
) -> tuple[float, float, float]:
    """Fit a turn and a slide to a displacement field, by weighted least squares.

    The slide is the weighted mean displacement; the turn about the weighted centre has a closed
    form (the two-dimensional orthogonal Procrustes problem). Each reweighting divides the weight
    by 1 + (misfit / rms misfit)^2, so that what does not turn with the imprint drops out.

    The field holds displacements (x, y) in px, (rows, columns, 2); the weight is (rows, columns),
    not negative; `grid_px` is the distance of neighbouring points, of x and y where they differ.

    Returns:
        Turn in rad, positive clockwise as drawn; slide along x and y in px. Zeros when there is
        no weight.
    """
    rows, columns = weight.shape
    grid_x, grid_y = np.broadcast_to(np.float32(grid_px), 2)
    x = np.arange(columns, dtype=np.float32)[None, :] * grid_x
    y = np.arange(rows, dtype=np.float32)[:, None] * grid_y
    step_x, step_y = field[..., 0], field[..., 1]
    active = weight
    turn = slide_x = slide_y = 0.0
    for round_number in range(reweightings + 1):
        total = float(active.sum())
        if total <= 0:
            return 0.0, 0.0, 0.0
        slide_x, slide_y = (float((active * step).sum()) / total for step in (step_x, step_y))
        arm_x = x - float((active * x).sum()) / total
        arm_y = y - float((active * y).sum()) / total
        moved_x, moved_y = arm_x + (step_x - slide_x), arm_y + (step_y - slide_y)
        across = float((active * (arm_x * moved_y - arm_y * moved_x)).sum())
        along = float((active * (arm_x * moved_x + arm_y * moved_y)).sum())
        turn = float(np.arctan2(across, along))
        if round_number < reweightings:
            cosine, sine = np.float32(np.cos(turn)), np.float32(np.sin(turn))
            misfit = (moved_x - cosine * arm_x + sine * arm_y) ** 2
            misfit += (moved_y - sine * arm_x - cosine * arm_y) ** 2
            scale = float((weight * misfit).sum() / weight.sum())
            active = weight / (1 + misfit / max(scale, MISFIT_FLOOR))
    return turn, slide_x, slide_y


def radius_of_gyration(weight: Field) -> float:
    """Return the weighted rms distance from the weighted centre, in grid steps."""
    total = float(weight.sum())
    if total <= 0:
        return 0.0
    rows, columns = weight.shape
    x, y = np.arange(columns), np.arange(rows)
    by_column, by_row = weight.sum(axis=0) / total, weight.sum(axis=1) / total
    variance_x = float(by_column @ x**2 - (by_column @ x) ** 2)
    variance_y = float(by_row @ y**2 - (by_row @ y) ** 2)
    return float(np.sqrt(max(variance_x + variance_y, 0.0)))
