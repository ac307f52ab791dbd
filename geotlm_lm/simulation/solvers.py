"""Contact of a rigid profile with an elastic body, step by step; knows no scene and no preset.

Pressing finds p >= 0 with gap g = S p + f - delta >= 0 and p g = 0 on every cell (a convex
quadratic programme) by conjugate gradients on the active cells, restarted per sample when its set
changes (Polonsky and Keer, Wear 231, 1999). Stick and slip of one quasi-static increment minimises
q.A q / 2 - q.b over |q_i| <= mu p_i, a convex quadratic programme over discs, by the spectral
projected gradient method with exact line search and alternating Barzilai-Borwein steps (Birgin,
Martinez and Raydan, SIAM J. Optim. 10, 2000). Its optimality conditions are exactly Coulomb's law:
a cell inside its disc moves with the object, one on its rim slips along its traction.

The march goes along a path with history. The grid is fixed to the gel, so that history needs no
bookkeeping: a cell that leaves the contact is released, one that enters starts from where the gel
is. All is done in batches whose samples never influence each other; tractions are in units of the
shear modulus, lengths in mm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from geotlm_lm.simulation.elastic import HalfSpaceOperator, LayerOperator

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

LEAST_INCREMENT_MM = 1e-6
"""Increment below which nothing needs to be solved: a nanometre."""


@dataclass(frozen=True)
class Effort:
    """How hard a step is solved: budgets, and the residuals that end them."""

    normal_rounds: Sequence[int] = ROUNDS
    friction_iterations: int = 400
    # Alternations of the two problems, at least; on a pad as thick as a GelSight's a third changes
    # the height by 1 um at most.
    passes: int = 2
    # At most, spent while drag lifts the surface off its solution: thin incompressible layers
    # couple strongly.
    most_passes: int = 24
    penetration_um: float = PENETRATION_LIMIT_UM
    # Where a budget of the normal problem is not spent any further; the grid's own error is larger
    # (1 to 34 um RMS from `fast` to `draft`, measured).
    enough_um: float = 0.0
    gradient_share: float = 1e-4


Response = LayerOperator | HalfSpaceOperator


@dataclass(frozen=True)
class SolverStatus:
    """How well a clip's contact problem was solved."""

    penetration_um: float  # largest overlap left, or gap under a cell that presses
    is_converged: bool  # every residual is acceptable; running out of steps is not
    preset: str = ""  # the one that gave the result, as asked for or harder
    gradient_share: float = 0.0  # projected gradient of friction relative to the increment
    cone_excess: float = 0.0  # of a traction over its friction disc, relative to the widest
    increments: int = 0  # marched through with friction; as many as frames if every step is small


@dataclass(frozen=True)
class Pressed:
    """Solution of a batch: fields (n, side, side), penetration left (n,)."""

    pressure: Tensor
    indentation_mm: Tensor
    penetration_um: Tensor


def solve_normal_contact(
    overlap_mm: Tensor, response: Response, effort: Effort, *, guess: Tensor | None = None
) -> Pressed:
    """Press every sample without friction; exact zeros where nothing overlaps.

    The overlap is delta - f, (n, side, side), very negative outside the object, less the bulge of
    tangential tractions. Later rounds are spent only where the penetration is too large. `guess`
    is the pressure to start from; by default one made from the overlap.
    """
    pressure, indentation = torch.zeros_like(overlap_mm), torch.zeros_like(overlap_mm)
    penetration = overlap_mm.new_zeros(len(overlap_mm))
    pending = (overlap_mm.flatten(1).amax(1) > 0).nonzero().flatten()
    if len(pending):
        start = None if guess is None else guess[pending]
        guessed = _first_guess(overlap_mm[pending], response, start)
        pressure[pending], indentation[pending] = guessed
    for budget in effort.normal_rounds:
        if len(pending) == 0:
            break
        fields = (field[pending] for field in (pressure, indentation, overlap_mm))
        solved = _conjugate_gradients(*fields, response, budget, effort.enough_um)
        pressure[pending], indentation[pending], left = solved
        penetration[pending] = left
        pending = pending[left > effort.penetration_um]
    return Pressed(pressure, indentation, penetration)


def _first_guess(
    overlap_mm: Tensor, response: Response, start: Tensor | None
) -> tuple[Tensor, Tensor]:
    """Return c * max(overlap - GUESS_LEVEL * peak, 0), with the c that minimises the energy.

    A sample of `start` that presses at all is taken as it is. Returns pressure and indentation.
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
) -> tuple[Tensor, Tensor, Tensor]:
    """Spend `budget` steps on every sample, fewer on one that is solved to `enough_um` before.

    Returns the pressure, its indentation, and the penetration left in micrometres, (n,).
    """
    direction = torch.zeros_like(pressure)
    old_square = pressure.new_ones(len(pressure), 1, 1)
    restart = torch.ones(len(pressure), 1, 1, dtype=torch.bool)
    going = restart
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
        restart = pressure.amin((1, 2), keepdim=True) < 0
        pressure.clamp_min_(0.0)
        old_square = square
        indentation = response.press(pressure)
    return pressure, indentation, misfit_um(overlap_mm, indentation, pressure)


def _dot(first: Tensor, second: Tensor) -> Tensor:
    """Return the product of fields (n, ..., side, side), summed over each sample."""
    return (first * second).sum(tuple(range(1, first.dim())), keepdim=True)


def misfit_um(overlap_mm: Tensor, indentation_mm: Tensor, pressure: Tensor) -> Tensor:
    """Return the largest penetration, or gap under a cell that presses, in micrometres, (n,)."""
    penetration = overlap_mm - indentation_mm
    wrong = torch.where(pressure > 0, penetration.abs(), penetration.clamp_min(0.0))
    return 1e3 * wrong.flatten(1).amax(1)


def solve_friction(
    target_mm: Tensor, limit: Tensor, response: Response, effort: Effort, *, guess: Tensor
) -> tuple[Tensor, Tensor]:
    """Return tractions (n, 2, side, side) and their gradient shares (n,).

    The gradient share is the RMS of the projected gradient over the contact relative to what the
    increment asks for, or to what the discs allow where that is less: otherwise a small increment
    after a large one, or little friction, would count as solved before the first step.

    The target b is the tangential displacement under which a sticking cell moves with the object,
    (n, 2, side, side), from tangential tractions alone. The limit is mu p >= 0, (n, side, side);
    infinity under unlimited friction is not allowed. `guess` are the tractions to start from.
    """
    natural = 1.0 / response.shear_diagonal
    touched = (limit > 0)[:, None]
    traction = onto_discs(guess, limit)
    gradient = torch.where(touched, response.shear(traction) - target_mm, 0.0)
    allowed = _rms(limit[:, None], touched) / natural
    asked = torch.minimum(_rms(gradient, touched), allowed).clamp_min(LEAST_INCREMENT_MM)
    length = torch.full_like(asked, natural)
    share = _gradient_share(traction, gradient, limit, natural, touched, asked)
    for iteration in range(effort.friction_iterations):
        if not bool((share > effort.gradient_share).any()):
            break
        direction = onto_discs(traction - length * gradient, limit) - traction
        image = torch.where(touched, response.shear(direction), 0.0)
        slope, curvature = _dot(gradient, direction), _dot(direction, image)
        step = (-slope / curvature.clamp_min(TINY)).clamp(0.0, 1.0)
        traction = traction + step * direction
        gradient = gradient + step * image
        if iteration % 2 == 0:
            length = _dot(direction, direction) / curvature.clamp_min(TINY)
        else:
            length = curvature / _dot(image, image).clamp_min(TINY)
        length = torch.where(curvature > 0, length, natural).clamp(0.01 * natural, 100 * natural)
        share = _gradient_share(traction, gradient, limit, natural, touched, asked)
    return traction, share


def onto_discs(traction: Tensor, limit: Tensor) -> Tensor:
    """Return the nearest tractions (n, 2, side, side) with |q_i| <= limit_i; 0 where limit is 0."""
    length = traction.norm(dim=1)
    scale = torch.where(length > limit, limit / length.clamp_min(TINY), 1.0)
    return traction * torch.where(limit > 0, scale, 0.0)[:, None]


def _gradient_share(traction, gradient, limit, natural: float, touched, asked) -> Tensor:
    moved = (traction - onto_discs(traction - natural * gradient, limit)) / natural
    return (_rms(moved, touched) / asked).flatten()


def _rms(field: Tensor, touched: Tensor) -> Tensor:
    count = touched.sum((1, 2, 3), keepdim=True).clamp_min(1)
    return (field.square().sum((1, 2, 3), keepdim=True) / count).sqrt()


@dataclass(frozen=True)
class Step:
    """The gel after one increment; scalar fields (n, side, side), vectors (n, 2, side, side).

    Args:
        pressure: Of the object on the gel, normal to it.
        traction: The same along it.
        indentation_mm: Displacement of the surface into the gel.
        drift_mm: The same along it.
        penetration_um: Largest overlap left, or gap under a cell that presses, (n,).
        gradient_share: Projected gradient of the frictional problem, (n,).
        work: Work the object did in this increment, energy per shear modulus, mm^3, (n,).
        energy: Elastic energy stored, mm^3, (n,).
    """

    pressure: Tensor
    traction: Tensor
    indentation_mm: Tensor
    drift_mm: Tensor
    penetration_um: Tensor
    gradient_share: Tensor
    work: Tensor
    energy: Tensor


def march(
    increments: Sequence[tuple[Tensor, Tensor]],
    response: Response,
    effort: Effort,
    *,
    friction_coefficient: float,
) -> Iterator[Step]:
    """Yield the gel after each increment, starting from a gel at rest.

    An increment is the approach less the object's profile at its new pose, (n, side, side), and the
    object's travel over each cell since the one before, i.e. (R(turn) - I)(x - old centre) + shift,
    (n, 2, side, side).
    """
    rest = torch.zeros_like(increments[0][0])
    plane, none = rest[:, None].expand(-1, 2, -1, -1), rest.new_zeros(len(rest))
    last = Step(rest, plane, rest, plane, none, none, none, none)
    mu = torch.as_tensor(friction_coefficient, dtype=rest.dtype)
    for overlap, travel in increments:
        last = _advance(last, overlap, travel, response, mu, effort)
        yield last


def _advance(last: Step, overlap_mm, travel_mm, response: Response, mu, effort: Effort) -> Step:
    traction, pressure = last.traction, last.pressure
    free = overlap_mm - response.bulge(traction)
    for done in range(1, effort.most_passes + 1):
        contact = solve_normal_contact(free, response, effort, guess=pressure)
        pressure = contact.pressure
        target = last.drift_mm + travel_mm - response.spread(pressure)
        traction, share = solve_friction(target, mu * pressure, response, effort, guess=traction)
        free = overlap_mm - response.bulge(traction)
        left_um = misfit_um(free, contact.indentation_mm, pressure)
        if done >= effort.passes and bool((left_um <= effort.penetration_um).all()):
            break
    indentation = response.press(pressure) + response.bulge(traction)
    drift = response.shear(traction) + response.spread(pressure)
    cell = response.cell_mm**2
    # Trapezoids: tractions grow from the old to the new ones while the object travels.
    pressed = (last.pressure + pressure) / 2 * (indentation - last.indentation_mm)
    dragged = (last.traction + traction) / 2 * travel_mm
    stored = (pressure * indentation).sum((1, 2)) + (traction * drift).sum((1, 2, 3))
    return Step(
        pressure=pressure,
        traction=traction,
        indentation_mm=indentation,
        drift_mm=drift,
        penetration_um=misfit_um(overlap_mm, indentation, pressure),
        gradient_share=share,
        work=(pressed.sum((1, 2)) + dragged.sum((1, 2, 3))) * cell,
        energy=stored / 2 * cell,
    )


def cell_centres(side: int, cell_mm: float, dtype: torch.dtype) -> Tensor:
    """Return (x, y) of every cell's centre, origin in the middle of the grid, (2, side, side)."""
    axis = (torch.arange(side, dtype=dtype) - (side - 1) / 2) * cell_mm
    return torch.stack([axis[None, :].expand(side, -1), axis[:, None].expand(-1, side)])


def rigid_travel(
    centres_mm: Tensor, old_centre_mm: Tensor, turn_rad: Tensor, shift_mm: Tensor
) -> Tensor:
    """Return how far the object travels over each cell, (n, 2, side, side).

    Cell centres are (2, side, side), the object's centre before the increment and its shift (n, 2),
    its turn, positive clockwise as drawn (x towards y), (n,).
    """
    arm = centres_mm[None] - old_centre_mm[:, :, None, None]
    cos, sin = (value[:, None, None] for value in (turn_rad.cos(), turn_rad.sin()))
    x = (cos - 1) * arm[:, 0] - sin * arm[:, 1]
    y = sin * arm[:, 0] + (cos - 1) * arm[:, 1]
    return torch.stack([x, y], dim=1) + shift_mm[:, :, None, None]
