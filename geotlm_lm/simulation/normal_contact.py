"""Frictionless contact of a rigid profile with the layer, as a batch; knows no optics or objects.

Finds p >= 0 with gap g = S p + f - delta >= 0 and p g = 0 on every cell (a convex quadratic
programme) by conjugate gradients on the active cells, restarted per sample when its set changes
(Polonsky and Keer, Wear 231, 1999). Pressures are in units of the shear modulus.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

PENETRATION_LIMIT_UM = 30.0
"""Residual penetration above which more iterations are spent; measured image error 1 grey."""

ROUNDS = (8, 16, 40, 100)
"""Iteration budgets: the first is the fast setting, the others are spent only where needed."""

GUESS_LEVEL = 0.35
"""Share of the overlap's peak above which the first guess presses: elastic contact covers roughly
half of the geometric overlap. It decides the speed only, not the solution."""

FEWEST_STEPS = 3
"""Steps spent before it is looked whether they were enough: hardly any scene needs less."""

TINY = 1e-30
"""Keeps 0 / 0 at 0 where a sample has nothing left to solve."""


class Response(Protocol):
    """What a body's surface does under tractions: `LayerOperator` or `HalfSpaceOperator`."""

    side: int
    cell_mm: float
    shear_diagonal: float

    def press(self, pressure: Tensor) -> Tensor: ...  # noqa: D102
    def bulge(self, traction: Tensor) -> Tensor: ...  # noqa: D102
    def spread(self, pressure: Tensor) -> Tensor: ...  # noqa: D102
    def shear(self, traction: Tensor) -> Tensor: ...  # noqa: D102


@dataclass(frozen=True)
class SolverStatus:
    """How well a clip's contact problem was solved.

    Args:
        penetration_um: Largest overlap left in any frame, or gap under a cell that presses.
        iterations: Conjugate-gradient steps spent on the hardest frame.
        is_converged: Whether every residual is acceptable; running out of steps is not.
        preset: The preset that gave the result, the one asked for or a harder one; empty for a
            problem solved outside of any.
        gradient_share: Projected gradient of the frictional problem relative to the increment.
        cone_excess: How far a traction leaves its friction disc, relative to the widest one.
        friction_iterations: Steps spent on the hardest frictional increment.
        dissipated_share: Work turned into heat by slip, relative to all the work put in; never
            below 0 but for the time steps' error.
        increments: Increments marched through with friction: as many as frames where every step
            is small; 0 without friction, where frames do not depend on each other.
    """

    penetration_um: float
    iterations: int
    is_converged: bool
    preset: str = ""
    gradient_share: float = 0.0
    cone_excess: float = 0.0
    friction_iterations: int = 0
    dissipated_share: float = 0.0
    increments: int = 0


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
    limit_um: float = PENETRATION_LIMIT_UM

    def status(self) -> SolverStatus:
        """Return the worst sample's residual and effort."""
        worst = float(self.penetration_um.max())
        return SolverStatus(worst, int(self.iterations.max()), worst <= self.limit_um)


def solve_normal_contact(
    overlap_mm: Tensor,
    response: Response,
    *,
    guess: Tensor | None = None,
    rounds: Sequence[int] | None = None,
    limit_um: float = PENETRATION_LIMIT_UM,
    enough_um: float = 0.0,
) -> Contact:
    """Solve the contact of every sample; samples never influence each other.

    Args:
        overlap_mm: delta - f, (n, side, side); very negative outside the object. Less the bulge of
            tangential tractions, where there are any.
        response: The elastic body.
        guess: Pressure to start from; by default one made from the overlap.
        rounds: Iteration budgets, by default `ROUNDS`; the later ones are spent only where the
            penetration is too large.
        limit_um: Penetration at which a sample is solved.
        enough_um: Penetration at which a sample's round ends before its budget is spent.

    Returns:
        The contact, exact zeros where nothing overlaps. `penetration_um` says how good it is; when
        it stays above the limit after the last round, the status is not converged.
    """
    pressure, indentation = torch.zeros_like(overlap_mm), torch.zeros_like(overlap_mm)
    penetration = overlap_mm.new_zeros(len(overlap_mm))
    iterations = torch.zeros(len(overlap_mm), dtype=torch.int64)
    pending = (overlap_mm.flatten(1).amax(1) > 0).nonzero().flatten()
    if len(pending):
        some = _where(pending, overlap_mm)
        start = None if guess is None else guess[some]
        pressure[some], indentation[some] = _first_guess(overlap_mm[some], response, start)
    for budget in ROUNDS if rounds is None else rounds:
        if len(pending) == 0:
            break
        some = _where(pending, overlap_mm)
        pressure[some], indentation[some], left, spent = _conjugate_gradients(
            pressure[some], indentation[some], overlap_mm[some], response, budget, enough_um
        )
        penetration[some] = left
        iterations[some] += spent
        pending = pending[left > limit_um]
    return Contact(pressure, indentation, pressure > 0, penetration, iterations, limit_um)


def _where(pending: Tensor, overlap_mm: Tensor) -> Tensor | slice:
    """Return the index of the pending samples: most often all, which then need no copying."""
    return slice(None) if len(pending) == len(overlap_mm) else pending


def _first_guess(
    overlap_mm: Tensor, response: Response, start: Tensor | None
) -> tuple[Tensor, Tensor]:
    """Return c * max(overlap - GUESS_LEVEL * peak, 0), with the c that minimises the energy.

    A sample of `start` that presses at all is taken as it is.

    Returns:
        The pressure and its indentation.
    """
    peak = overlap_mm.flatten(1).amax(1)[:, None, None]
    shape = (overlap_mm - GUESS_LEVEL * peak).clamp_min(0.0)
    image = response.press(shape)
    work, energy = _dot(shape, overlap_mm.clamp_min(-1e3)), _dot(shape, image)
    scale = work / energy.clamp_min(TINY)
    fresh = shape * scale
    if start is None:
        return fresh, image * scale
    pressure = torch.where(start.flatten(1).any(1)[:, None, None], start, fresh)
    return pressure, response.press(pressure)


def _conjugate_gradients(
    pressure: Tensor,
    indentation: Tensor,
    overlap_mm: Tensor,
    response: Response,
    budget: int,
    enough_um: float,
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Spend `budget` steps on every sample, fewer on one that is solved to `enough_um` before.

    Returns:
        The pressure, its indentation, the penetration left in micrometres, and the steps, (n,).
    """
    direction = torch.zeros_like(pressure)
    old_square = pressure.new_ones(len(pressure), 1, 1)
    restart = torch.ones(len(pressure), 1, 1, dtype=torch.bool)
    going, spent = restart, torch.zeros(len(pressure), dtype=torch.int64)
    for step_number in range(budget):
        residual = overlap_mm - indentation
        # Passes over a small grid cost their calls: factors of 0 and 1 take the place of choices.
        active = (torch.maximum(pressure, residual) > 0).to(pressure.dtype)
        residual *= active
        if enough_um > 0 and step_number >= FEWEST_STEPS:
            # What is left on the active cells is what `misfit_um` counts.
            going = 1e3 * residual.abs().amax((1, 2), keepdim=True) > enough_um
            if not going.any():
                break
        square = _dot(residual, residual)
        keep = torch.where(restart, 0.0, square / old_square.clamp_min(TINY))
        direction = torch.addcmul(residual, direction, keep).mul_(active)
        image = response.press(direction)
        step = _dot(residual, direction) / _dot(direction, image).clamp_min_(TINY)
        # A sample that is done stands still: none depends on which others are solved beside it.
        pressure = torch.addcmul(pressure, direction, step * going)
        spent += going.flatten()
        restart = pressure.amin((1, 2), keepdim=True) < 0
        pressure.clamp_min_(0.0)
        old_square = square
        indentation = response.press(pressure)
    return pressure, indentation, misfit_um(overlap_mm, indentation, pressure), spent


def _dot(one: Tensor, other: Tensor) -> Tensor:
    return (one * other).sum((1, 2), keepdim=True)


def misfit_um(overlap_mm: Tensor, indentation_mm: Tensor, pressure: Tensor) -> Tensor:
    """Return the largest penetration, or gap under a cell that presses, in micrometres, (n,)."""
    penetration = overlap_mm - indentation_mm
    wrong = torch.where(pressure > 0, penetration.abs(), penetration.clamp_min(0.0))
    return 1e3 * wrong.flatten(1).amax(1)
