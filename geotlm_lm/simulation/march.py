"""Quasi-static march of a rigid object over the gel, with history; a batch of equal lengths.

The grid is fixed to the gel, so that history needs no bookkeeping: a cell that leaves the contact
is released, one that enters starts from where the gel is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from geotlm_lm.simulation.friction import solve_friction
from geotlm_lm.simulation.normal_contact import (
    PENETRATION_LIMIT_UM,
    ROUNDS,
    Response,
    misfit_um,
    solve_normal_contact,
)


@dataclass(frozen=True)
class Effort:
    """How hard a step is solved.

    Args:
        normal_rounds: Iteration budgets of the normal problem.
        friction_iterations: Steps of the frictional problem, at most.
        passes: Alternations of the two problems, at least; on a pad as thick as a GelSight's a
            third changes the height by 1 um at most.
        most_passes: Alternations at most, spent while drag lifts the surface off its solution: thin
            incompressible layers couple strongly.
        penetration_um: Penetration at which the normal problem is solved.
        enough_um: Penetration at which a budget of the normal problem is not spent any further; the
            grid's own error is larger (1 to 34 um RMS from `fast` to `draft`, measured).
        gradient_share: Projected gradient at which the frictional problem is solved.
    """

    normal_rounds: Sequence[int] = ROUNDS
    friction_iterations: int = 400
    passes: int = 2
    most_passes: int = 24
    penetration_um: float = PENETRATION_LIMIT_UM
    enough_um: float = 0.0
    gradient_share: float = 1e-4


TIGHT = Effort(
    normal_rounds=(50, 100, 400, 1000),
    friction_iterations=2000,
    passes=3,
    penetration_um=1e-4,
    gradient_share=1e-7,
)
"""For verification: grid error dominates everything else."""


@dataclass(frozen=True)
class Step:
    """The gel after one increment; tractions in units of the shear modulus, lengths in mm.

    Args:
        pressure: (n, side, side).
        traction: Tangential traction of the object on the gel, (n, 2, side, side).
        indentation_mm: (n, side, side).
        drift_mm: Tangential displacement of the surface, (n, 2, side, side).
        sticks: Cells in contact inside their friction disc, bool (n, side, side).
        penetration_um: Largest overlap left, or gap under a cell that presses, (n,).
        gradient_share: Projected gradient of the frictional problem, (n,).
        work: Work the object did in this increment, energy per shear modulus, mm^3, (n,).
        energy: Elastic energy stored, mm^3, (n,).
        iterations: Steps spent on the normal and on the frictional problem.
    """

    pressure: Tensor
    traction: Tensor
    indentation_mm: Tensor
    drift_mm: Tensor
    sticks: Tensor
    penetration_um: Tensor
    gradient_share: Tensor
    work: Tensor
    energy: Tensor
    iterations: tuple[int, int]

    def force(self, cell_mm: float) -> Tensor:
        """Return the force (x, y, z) on the gel, per shear modulus, mm^2, (n, 3)."""
        plane = self.traction.sum((2, 3))
        return torch.cat([plane, self.pressure.sum((1, 2))[:, None]], dim=1) * cell_mm**2

    def moment(self, cell_mm: float, centre_mm: Tensor) -> Tensor:
        """Return the moment about the normal at `centre_mm` (n, 2), per shear modulus, mm^3."""
        arm = cell_centres(self.pressure.shape[-1], cell_mm, self.pressure.dtype)
        arm = arm[None] - centre_mm[:, :, None, None]
        turn = arm[:, 0] * self.traction[:, 1] - arm[:, 1] * self.traction[:, 0]
        return turn.sum((1, 2)) * cell_mm**2


@dataclass(frozen=True)
class Increment:
    """What the object does in one increment.

    Args:
        overlap_mm: Approach less the object's profile at its new pose, (n, side, side).
        travel_mm: Travel of the object over each cell since the increment before, i.e.
            (R(turn) - I)(x - old centre) + shift, (n, 2, side, side).
    """

    overlap_mm: Tensor
    travel_mm: Tensor


def march(
    increments: Sequence[Increment],
    response: Response,
    *,
    friction_coefficient: float | Tensor,
    effort: Effort | None = None,
) -> Iterator[Step]:
    """Yield the gel after each increment, starting from a gel at rest.

    Args:
        increments: What happens, in order.
        response: The elastic body.
        friction_coefficient: mu >= 0, one number or (n,).
        effort: How hard each step is solved.
    """
    effort = effort or Effort()
    mu = torch.as_tensor(friction_coefficient, dtype=increments[0].overlap_mm.dtype)
    mu = mu.reshape(-1, 1, 1)
    last = _at_rest(increments[0].overlap_mm)
    for increment in increments:
        last = _advance(last, increment, response, mu, effort)
        yield last


def _advance(
    last: Step, increment: Increment, response: Response, mu: Tensor, effort: Effort
) -> Step:
    traction, pressure = last.traction, last.pressure
    free = increment.overlap_mm - response.bulge(traction)
    normal_spent = friction_spent = 0
    for done in range(1, effort.most_passes + 1):
        contact = solve_normal_contact(
            free,
            response,
            guess=pressure,
            rounds=effort.normal_rounds,
            limit_um=effort.penetration_um,
            enough_um=effort.enough_um,
        )
        pressure = contact.pressure
        target = last.drift_mm + increment.travel_mm - response.spread(pressure)
        friction = solve_friction(
            target,
            mu * pressure,
            response,
            guess=traction,
            most_iterations=effort.friction_iterations,
            tolerance=effort.gradient_share,
        )
        traction = friction.traction
        normal_spent += int(contact.iterations.max())
        friction_spent += friction.iterations
        free = increment.overlap_mm - response.bulge(traction)
        left_um = misfit_um(free, contact.indentation_mm, pressure)
        if done >= effort.passes and bool((left_um <= effort.penetration_um).all()):
            break
    return _step_from(
        last, increment, response, contact, friction, mu, normal_spent, friction_spent
    )


def _step_from(
    last, increment, response, contact, friction, mu, normal_spent: int, friction_spent: int
) -> Step:
    pressure, traction = contact.pressure, friction.traction
    indentation = response.press(pressure) + response.bulge(traction)
    drift = response.shear(traction) + response.spread(pressure)
    cell = response.cell_mm**2
    # Trapezoids: tractions grow from the old to the new ones while the object travels.
    pressed = (last.pressure + pressure) / 2 * (indentation - last.indentation_mm)
    dragged = (last.traction + traction) / 2 * increment.travel_mm
    stored = (pressure * indentation).sum((1, 2)) + (traction * drift).sum((1, 2, 3))
    touched = pressure > 0
    limit = mu * pressure
    return Step(
        pressure=pressure,
        traction=traction,
        indentation_mm=indentation,
        drift_mm=drift,
        sticks=touched & (traction.norm(dim=1) < (1 - 1e-6) * limit),
        penetration_um=misfit_um(increment.overlap_mm, indentation, pressure),
        gradient_share=friction.gradient_share,
        work=(pressed.sum((1, 2)) + dragged.sum((1, 2, 3))) * cell,
        energy=stored / 2 * cell,
        iterations=(normal_spent, friction_spent),
    )


def _at_rest(like: Tensor) -> Step:
    zero, plane = torch.zeros_like(like), torch.zeros_like(like)[:, None].expand(-1, 2, -1, -1)
    none = like.new_zeros(len(like))
    return Step(zero, plane, zero, plane, zero > 0, none, none, none, none, (0, 0))


def cell_centres(side: int, cell_mm: float, dtype: torch.dtype) -> Tensor:
    """Return (x, y) of every cell's centre, origin in the middle of the grid, (2, side, side)."""
    axis = (torch.arange(side, dtype=dtype) - (side - 1) / 2) * cell_mm
    return torch.stack([axis[None, :].expand(side, -1), axis[:, None].expand(-1, side)])


def rigid_travel(
    centres_mm: Tensor, old_centre_mm: Tensor, turn_rad: Tensor, shift_mm: Tensor
) -> Tensor:
    """Return how far the object travels over each cell, (n, 2, side, side).

    Args:
        centres_mm: Cell centres, (2, side, side).
        old_centre_mm: Object's centre before the increment, (n, 2).
        turn_rad: Turn of the increment, positive clockwise as drawn (x towards y), (n,).
        shift_mm: Travel of the object's centre, (n, 2).
    """
    arm = centres_mm[None] - old_centre_mm[:, :, None, None]
    cos, sin = (value[:, None, None] for value in (turn_rad.cos(), turn_rad.sin()))
    x = (cos - 1) * arm[:, 0] - sin * arm[:, 1]
    y = sin * arm[:, 0] + (cos - 1) * arm[:, 1]
    return torch.stack([x, y], dim=1) + shift_mm[:, :, None, None]
