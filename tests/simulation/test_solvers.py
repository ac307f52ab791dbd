"""Laws of a contact, Coulomb's law cell by cell, and laws of the march along a path."""

import pytest
import torch

from geotlm_lm.simulation.solvers import (
    Effort,
    cell_centres,
    march,
    rigid_travel,
    solve_friction,
    solve_normal_contact,
)
from tests.simulation.contact_problems import MU, TIGHT, lopsided, marched, pad, turn

LAYER = pad()
X, Y = CENTRES = cell_centres(32, LAYER.cell_mm, torch.float64)
PRESSURE = (1 - (X**2 + Y**2) / 16).clamp_min(0).sqrt()[None]


def test_a_sample_is_solved_alike_alone_and_beside_harder_ones():
    easy = lopsided(LAYER)
    together = solve_normal_contact(torch.cat([easy, 3 * easy + 1, easy - 9]), LAYER, Effort())
    alone = solve_normal_contact(easy, LAYER, Effort())
    assert torch.allclose(together.pressure[0], alone.pressure[0], atol=1e-4)
    assert not together.pressure[2].any()


def turned(angle):
    return torch.stack([-angle * Y, angle * X])[None]


def slid(x, y=0.0):
    return torch.stack([torch.full_like(X, x), torch.full_like(X, y)])[None]


def solved(target, limit):
    effort = Effort(friction_iterations=2000, gradient_share=1e-8)
    return solve_friction(target, limit, LAYER, effort, guess=torch.zeros_like(target))


@pytest.mark.parametrize(
    ("target", "regime"),
    [
        (turned(0.05), (True, True)),
        (turned(0.1) + slid(0.2), (True, True)),
        (slid(0.1, 0.05), (True, True)),
        (slid(9.0), (False, True)),
    ],
)
def test_inside_the_disc_a_cell_sticks_and_on_its_rim_it_slips_along_its_traction(target, regime):
    limit = 0.5 * PRESSURE
    traction, share, _ = solved(target, limit)
    assert float(share) < 1e-8
    length = traction.norm(dim=1)
    assert float((length - limit).max()) < 1e-12
    slip = torch.where((limit > 0)[:, None], target - LAYER.shear(traction), 0.0)
    sticks = (limit > 0) & (length < (1 - 1e-6) * limit)
    assert float((slip.norm(dim=1) * sticks).max()) < 1e-6
    # A slipping cell's traction lies along the slip, against which it pulls the gel along.
    rubs = (limit > 0) & ~sticks
    along = (slip * traction).sum(1)
    assert float(((along - slip.norm(dim=1) * length).abs() * rubs).max()) < 1e-6
    assert (bool(sticks.any()), bool(rubs.any())) == regime


def test_samples_do_not_influence_each_other():
    limit = 0.5 * PRESSURE
    both, *_ = solved(torch.cat([turned(0.1), slid(5.0)]), torch.cat([limit, 0 * limit]))
    alone, *_ = solved(turned(0.1), limit)
    assert torch.allclose(both[0], alone[0], atol=1e-6)
    assert not both[1].any()


MIRROR = torch.tensor([-1.0, 1.0], dtype=torch.float64).view(1, 2, 1, 1)
"""What a mirror left to right does to a vector."""


def deviation(field, exact):
    return float((field - exact).abs().max() / exact.abs().max())


def twisted(scale=1.0):
    layer = pad(scale=scale)
    return marched(layer, lopsided(layer, scale), turn(0.05)).end


def test_a_mirrored_twist_leaves_the_mirrored_surface():
    plain = twisted()
    mirrored = marched(LAYER, lopsided(LAYER).flip(2), turn(-0.05)).end
    assert deviation(mirrored.drift_mm.flip(3) * MIRROR, plain.drift_mm) < 1e-6
    assert deviation(mirrored.indentation_mm.flip(2), plain.indentation_mm) < 1e-6


def test_a_twist_clockwise_takes_the_top_to_the_right_and_the_right_down():
    still = torch.zeros(1, 2, dtype=torch.float64)
    travel = rigid_travel(CENTRES, still, still[0, :1] + 0.03, still)
    step = marched(LAYER, lopsided(LAYER), lambda _: travel).end
    touched, drift = step.pressure[0] > 0, step.drift_mm[0]
    assert float(drift[0][touched & (Y < 0)].mean()) > 0
    assert float(drift[0][touched & (Y > 0)].mean()) < 0
    assert float(drift[1][touched & (X > 0)].mean()) > 0


def test_a_larger_gel_moves_in_proportion():
    # The solver stops at lengths of its own: only its tolerance, 1e-7, is common.
    assert deviation(twisted(scale=2.5).drift_mm / 2.5, twisted().drift_mm) < 1e-5


def test_a_cell_that_leaves_the_contact_is_released():
    pressed, rest = lopsided(LAYER), torch.zeros(1, 2, 32, 32, dtype=torch.float64)
    path = [(pressed, rest), (pressed, turn(0.05)(CENTRES)), (pressed - 10, rest)]
    *_, end = march(path, LAYER, TIGHT, friction_coefficient=MU)
    assert not end.traction.any()
    assert float(end.drift_mm.abs().max()) < 1e-12
    assert float(end.indentation_mm.abs().max()) < 1e-12
