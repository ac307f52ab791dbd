"""The solution obeys Coulomb's law cell by cell: those are the conditions of its optimality."""

import pytest
import torch

from geotlm_lm.simulation.elastic import LayerOperator
from geotlm_lm.simulation.friction import solve_friction
from geotlm_lm.simulation.march import cell_centres

SIDE = 32
LAYER = LayerOperator(SIDE, 16.0, thickness_mm=4.0, poisson_ratio=0.48, dtype=torch.float64)
X, Y = cell_centres(SIDE, 0.5, torch.float64)
PRESSURE = (1 - (X**2 + Y**2) / 16).clamp_min(0).sqrt()[None]


def turn(angle):
    return torch.stack([-angle * Y, angle * X])[None]


def slide(x, y=0.0):
    return torch.stack([torch.full_like(X, x), torch.full_like(X, y)])[None]


def solved(target, limit, most=2000):
    return solve_friction(
        target, limit, LAYER, guess=torch.zeros_like(target), most_iterations=most, tolerance=1e-8
    )


@pytest.mark.parametrize(
    ("target", "regime"),
    [
        (turn(0.05), (True, True)),
        (turn(0.1) + slide(0.2), (True, True)),
        (slide(0.1, 0.05), (True, True)),
        (slide(9.0), (False, True)),
    ],
)
def test_inside_the_disc_a_cell_sticks_and_on_its_rim_it_slips_along_its_traction(target, regime):
    limit = 0.5 * PRESSURE
    answer = solved(target, limit)
    assert float(answer.gradient_share) < 1e-8
    length = answer.traction.norm(dim=1)
    assert float((length - limit).max()) < 1e-12
    slip = torch.where((limit > 0)[:, None], target - LAYER.shear(answer.traction), 0.0)
    sticks = (limit > 0) & (length < (1 - 1e-6) * limit)
    assert float((slip.norm(dim=1) * sticks).max()) < 1e-6
    # A slipping cell's traction lies along the slip, against which it pulls the gel along.
    rubs = (limit > 0) & ~sticks
    along = (slip * answer.traction).sum(1)
    assert float(((along - slip.norm(dim=1) * length).abs() * rubs).max()) < 1e-6
    assert (bool(sticks.any()), bool(rubs.any())) == regime


def test_running_out_of_steps_is_told():
    answer = solved(turn(0.1), 0.5 * PRESSURE, most=2)
    assert answer.iterations == 2
    assert float(answer.gradient_share) > 1e-8


def test_samples_do_not_influence_each_other():
    limit = 0.5 * PRESSURE
    both = solved(torch.cat([turn(0.1), slide(5.0)]), torch.cat([limit, 0 * limit]))
    alone = solved(turn(0.1), limit)
    assert torch.allclose(both.traction[0], alone.traction[0], atol=1e-6)
    assert not both.traction[1].any()
