"""Frictionless contact of a rigid profile with the layer, as a batch; knows no optics or objects.

Finds p >= 0 with gap g = S p + f - delta >= 0 and p g = 0 on every cell (a convex quadratic
programme) by conjugate gradients on the active cells, restarted per sample when its set changes
(Polonsky and Keer, Wear 231, 1999). Pressures are in units of the shear modulus.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

PENETRATION_LIMIT_UM = 30.0
"""Residual penetration above which more iterations are spent; measured image error 1 grey."""

ROUNDS = (8, 16, 40, 100)
"""Iteration budgets: the first is the fast setting, the others are spent only where needed."""

GUESS_LEVEL = 0.35
"""Share of the overlap's peak above which the first guess presses: elastic contact covers roughly
half of the geometric overlap. It decides the speed only, not the solution."""

TINY = 1e-30
"""Keeps 0 / 0 at 0 where a sample has nothing left to solve."""


@dataclass(frozen=True)
class SolverStatus:
    """How well a clip's contact problem was solved.

    Args:
        penetration_um: Largest overlap left anywhere in any frame.
        iterations: Conjugate-gradient steps spent on the hardest frame.
        is_converged: Whether the penetration is below `PENETRATION_LIMIT_UM`.
    """

    penetration_um: float
    iterations: int
    is_converged: bool


@dataclass(frozen=True)
class Contact:
    """Solution of a batch; pressures in units of the shear modulus.

    pressure, indentation_mm, touches: (n, side, side); penetration_um, iterations: (n,).
    """

    pressure: Tensor
    indentation_mm: Tensor
    touches: Tensor
    penetration_um: Tensor
    iterations: Tensor

    def status(self) -> SolverStatus:
        """Return the worst sample's residual and effort."""
        worst = float(self.penetration_um.max())
        return SolverStatus(worst, int(self.iterations.max()), worst <= PENETRATION_LIMIT_UM)


def solve_normal_contact(overlap_mm: Tensor, compliance: Tensor) -> Contact:
    """Solve the contact of every sample; samples never influence each other.

    Args:
        overlap_mm: delta - f, float32 (n, side, side); -inf or very negative outside the object.
        compliance: S_zz on the half spectrum, float32, broadcastable to (n, side, side // 2 + 1).

    Returns:
        The contact, exact zeros where nothing overlaps. `penetration_um` says how good it is; when
        it stays above the limit after the last round, the status is not converged.
    """
    count, side, _ = overlap_mm.shape
    compliance = compliance.expand(count, side, side // 2 + 1)
    pressure = torch.zeros_like(overlap_mm)
    penetration = torch.zeros(count)
    iterations = torch.zeros(count, dtype=torch.int64)
    pending = (overlap_mm.flatten(1).amax(1) > 0).nonzero().flatten()
    if len(pending):
        pressure[pending] = _first_guess(overlap_mm[pending], compliance[pending])
    for budget in ROUNDS:
        if len(pending) == 0:
            break
        pressure[pending], left = _conjugate_gradients(
            pressure[pending], overlap_mm[pending], compliance[pending], budget
        )
        penetration[pending] = left
        iterations[pending] += budget
        pending = pending[left > PENETRATION_LIMIT_UM]
    indentation = torch.zeros_like(pressure)
    if iterations.any():
        indentation = apply_compliance(pressure, compliance)
    return Contact(pressure, indentation, pressure > 0, penetration, iterations)


def apply_compliance(pressure: Tensor, compliance: Tensor) -> Tensor:
    """Return the indentation S p of a pressure, shape (n, side, side)."""
    spectrum = torch.fft.rfft2(pressure) * compliance
    return torch.fft.irfft2(spectrum, s=pressure.shape[-2:])


def _first_guess(overlap_mm: Tensor, compliance: Tensor) -> Tensor:
    """Return c * max(overlap - GUESS_LEVEL * peak, 0), with the c that minimises the energy."""
    peak = overlap_mm.flatten(1).amax(1)[:, None, None]
    shape = (overlap_mm - GUESS_LEVEL * peak).clamp_min(0.0)
    work = (shape * overlap_mm.clamp_min(-1e3)).sum((1, 2), keepdim=True)
    energy = (shape * apply_compliance(shape, compliance)).sum((1, 2), keepdim=True)
    return shape * (work / energy.clamp_min(TINY))


def _conjugate_gradients(
    pressure: Tensor, overlap_mm: Tensor, compliance: Tensor, budget: int
) -> tuple[Tensor, Tensor]:
    """Spend `budget` steps; return the pressure and the penetration left in micrometres (n,)."""
    direction = torch.zeros_like(pressure)
    old_square = torch.ones(len(pressure), 1, 1)
    restart = torch.ones(len(pressure), 1, 1, dtype=torch.bool)
    for _ in range(budget):
        residual = overlap_mm - apply_compliance(pressure, compliance)
        active = (pressure > 0) | (residual > 0)
        residual = torch.where(active, residual, 0.0)
        square = residual.square().sum((1, 2), keepdim=True)
        keep = torch.where(restart, 0.0, square / old_square.clamp_min(TINY))
        direction = torch.where(active, residual + keep * direction, 0.0)
        image = apply_compliance(direction, compliance)
        curvature = (direction * image).sum((1, 2), keepdim=True)
        step = (residual * direction).sum((1, 2), keepdim=True) / curvature.clamp_min(TINY)
        moved = pressure + step * direction
        restart = (moved < 0).flatten(1).any(1)[:, None, None]
        pressure = moved.clamp_min(0.0)
        old_square = square
    residual = overlap_mm - apply_compliance(pressure, compliance)
    return pressure, 1e3 * residual.flatten(1).amax(1).clamp_min(0.0)
