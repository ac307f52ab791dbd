"""Coulomb stick and slip of one quasi-static increment, as a batch; knows no object and no path.

Minimises q.A q / 2 - q.b over |q_i| <= mu p_i, a convex quadratic programme over discs, by the
spectral projected gradient method with exact line search and alternating Barzilai-Borwein steps
(Birgin, Martinez and Raydan, SIAM J. Optim. 10, 2000). Its optimality conditions are exactly
Coulomb's law: a cell inside its disc moves with the object, one on its rim slips along its
traction.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from geotlm_lm.simulation.normal_contact import TINY, Response

LEAST_INCREMENT_MM = 1e-6
"""Increment below which nothing needs to be solved: a nanometre."""


@dataclass(frozen=True)
class Friction:
    """Solution of a batch of increments; tractions in units of the shear modulus.

    traction: (n, 2, side, side); gradient_share: (n,). The gradient share is the RMS of the
    projected gradient over the contact relative to what the increment asks for, or to what the
    discs allow where that is less: otherwise a small increment after a large one, or little
    friction, would count as solved before the first step.
    """

    traction: Tensor
    gradient_share: Tensor
    iterations: int


def solve_friction(
    target_mm: Tensor,
    limit: Tensor,
    response: Response,
    *,
    guess: Tensor,
    most_iterations: int,
    tolerance: float = 1e-5,
) -> Friction:
    """Solve the tractions of every sample; samples never influence each other.

    Args:
        target_mm: b, the tangential displacement under which a sticking cell moves with the object,
            (n, 2, side, side), from tangential tractions alone.
        limit: mu p >= 0, (n, side, side); infinity under unlimited friction is not allowed.
        response: The elastic body.
        guess: Tractions to start from.
        most_iterations: Steps spent at most.
        tolerance: Gradient share at which all samples are solved.
    """
    natural = 1.0 / response.shear_diagonal
    touched = (limit > 0)[:, None]
    traction = onto_discs(guess, limit)
    gradient = torch.where(touched, response.shear(traction) - target_mm, 0.0)
    allowed = _rms(limit[:, None], touched) / natural
    asked = torch.minimum(_rms(gradient, touched), allowed).clamp_min(LEAST_INCREMENT_MM)
    length = torch.full_like(asked, natural)
    iteration = 0
    share = _gradient_share(traction, gradient, limit, natural, touched, asked)
    while iteration < most_iterations and bool((share > tolerance).any()):
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
        iteration += 1
        share = _gradient_share(traction, gradient, limit, natural, touched, asked)
    return Friction(traction, share, iteration)


def onto_discs(traction: Tensor, limit: Tensor) -> Tensor:
    """Return the nearest tractions (n, 2, side, side) with |q_i| <= limit_i; 0 where limit is 0."""
    length = traction.norm(dim=1)
    scale = torch.where(length > limit, limit / length.clamp_min(TINY), 1.0)
    return traction * torch.where(limit > 0, scale, 0.0)[:, None]


def _gradient_share(
    traction: Tensor,
    gradient: Tensor,
    limit: Tensor,
    natural: float,
    touched: Tensor,
    asked: Tensor,
) -> Tensor:
    moved = (traction - onto_discs(traction - natural * gradient, limit)) / natural
    return (_rms(moved, touched) / asked).flatten()


def _rms(field: Tensor, touched: Tensor) -> Tensor:
    count = touched.sum((1, 2, 3), keepdim=True).clamp_min(1)
    return (field.square().sum((1, 2, 3), keepdim=True) / count).sqrt()


def _dot(one: Tensor, other: Tensor) -> Tensor:
    return (one * other).sum((1, 2, 3), keepdim=True)
