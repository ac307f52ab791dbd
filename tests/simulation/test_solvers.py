"""Laws of a contact, Coulomb's law cell by cell, and laws of the march along a path."""

import numpy as np
import pytest
import torch

from geotlm_lm.simulation.elastic import LayerOperator
from geotlm_lm.simulation.solvers import (
    PENETRATION_LIMIT_UM,
    ROUNDS,
    Effort,
    cell_centres,
    march,
    rigid_travel,
    solve_friction,
    solve_normal_contact,
)
from tests.simulation.contact_problems import MU, TIGHT, lopsided, marched, pad, turn

SIDE, BOX = 48, 25.6


def grid():
    axis = (np.arange(SIDE) + 0.5 - SIDE / 2) * BOX / SIDE
    return np.meshgrid(axis, axis)


def overlap(height, depth):
    return torch.tensor(depth - np.asarray(height), dtype=torch.float32)[None]


def layer(thickness_mm=4.0, poisson_ratio=0.48):
    return LayerOperator(SIDE, BOX, thickness_mm=thickness_mm, poisson_ratio=poisson_ratio)


def rough(seed=0):
    x, y = grid()
    rng = np.random.default_rng(seed)
    return (x**2 + y**2) / 30 + 0.1 * np.abs(rng.standard_normal(x.shape))


@pytest.mark.parametrize("seed", [0, 1])
def test_pressure_is_never_tensile_and_acts_only_where_the_gap_is_closed(seed):
    gap_open = overlap(rough(seed), 0.6)
    contact = solve_normal_contact(gap_open, layer(), Effort())
    gap = contact.indentation_mm - gap_open
    assert float(contact.pressure.min()) >= 0
    assert float(gap.min()) > -5e-3
    work = float((contact.pressure * gap).abs().sum() / (contact.pressure.sum() * 0.6))
    assert work < 5e-3
    assert float(contact.penetration_um) <= PENETRATION_LIMIT_UM


@pytest.mark.parametrize("depth", [0.0, -0.3])
def test_without_overlap_everything_is_exactly_zero(depth):
    x, y = grid()
    contact = solve_normal_contact(overlap(np.hypot(x, y) ** 2, depth), layer(), Effort())
    assert not contact.pressure.any()
    assert not contact.indentation_mm.any()
    assert not contact.penetration_um.any()


def test_a_sample_is_solved_alike_alone_and_beside_harder_ones():
    x, y = grid()
    cases = [overlap(rough(), 0.4), overlap(np.zeros_like(x), 1.2), overlap(x**2 + y**2, 0.0)]
    together = solve_normal_contact(torch.cat(cases), layer(), Effort())
    alone = solve_normal_contact(cases[0], layer(), Effort())
    assert torch.allclose(together.pressure[0], alone.pressure[0], atol=1e-4)
    assert not together.pressure[2].any()


def test_a_hard_case_gets_more_iterations_and_an_unsolved_one_says_what_is_left():
    gap_open, thin = overlap(rough(4) * 3, 3.5), layer(0.3, 0.5)
    starved, first, generous = (
        float(solve_normal_contact(gap_open, thin, Effort(rounds)).penetration_um)
        for rounds in ((1,), ROUNDS[:1], ROUNDS)
    )
    assert starved > 30
    assert first > PENETRATION_LIMIT_UM
    assert generous < first


LAYER = pad()
CENTRES = cell_centres(LAYER.side, LAYER.cell_mm, torch.float64)
PRESSURE = (1 - CENTRES.square().sum(dim=0) / 16).clamp_min(0).sqrt()[None]


def turned(angle):
    return turn(angle)(CENTRES)


def slid(x, y=0.0):
    return torch.tensor([x, y], dtype=torch.float64)[None, :, None, None].expand_as(CENTRES[None])


def solved(target, limit, most=2000):
    effort = Effort(friction_iterations=most, gradient_share=1e-8)
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
    traction, share = solved(target, limit)
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


def test_running_out_of_steps_is_told():
    _, share = solved(turned(0.1), 0.5 * PRESSURE, most=2)
    assert float(share) > 1e-8


def test_samples_do_not_influence_each_other():
    limit = 0.5 * PRESSURE
    both, _ = solved(torch.cat([turned(0.1), slid(5.0)]), torch.cat([limit, 0 * limit]))
    alone, _ = solved(turned(0.1), limit)
    assert torch.allclose(both[0], alone[0], atol=1e-6)
    assert not both[1].any()


MIRROR = torch.tensor([-1.0, 1.0], dtype=torch.float64).view(1, 2, 1, 1)
"""What a mirror left to right does to a vector."""


def deviation(found, exact):
    return float((found - exact).abs().max() / exact.abs().max())


def twisted(modulus=1.0, scale=1.0):
    layer = pad(scale=scale, shear_modulus=modulus)
    return marched(layer, lopsided(layer, scale), turn(0.05)).end


def test_a_mirrored_twist_leaves_the_mirrored_surface():
    layer, plain = pad(), twisted()
    mirrored = marched(layer, lopsided(layer).flip(2), turn(-0.05)).end
    assert deviation(mirrored.drift_mm.flip(3) * MIRROR, plain.drift_mm) < 1e-6
    assert deviation(mirrored.indentation_mm.flip(2), plain.indentation_mm) < 1e-6


def test_a_twist_clockwise_takes_the_top_to_the_right_and_the_right_down():
    rest = torch.zeros(1, 2, dtype=torch.float64)
    travel = rigid_travel(CENTRES, rest, rest[:, 0] + 0.03, rest)
    step = marched(LAYER, lopsided(LAYER), lambda _: travel).end
    touched, (x, y) = step.pressure[0] > 0, CENTRES
    drift = step.drift_mm[0]
    assert float(drift[0][touched & (y < 0)].mean()) > 0
    assert float(drift[0][touched & (y > 0)].mean()) < 0
    assert float(drift[1][touched & (x > 0)].mean()) > 0


def test_a_stiffer_gel_moves_alike_and_a_larger_one_in_proportion():
    # Under displacement control the modulus drops out of what is seen.
    assert deviation(twisted(modulus=1e4).drift_mm, twisted().drift_mm) < 1e-6
    # The solver stops at lengths of its own, so that only its tolerance, 1e-7, is common.
    assert deviation(twisted(scale=2.5).drift_mm / 2.5, twisted().drift_mm) < 1e-5


def test_work_is_stored_or_rubbed_away_and_none_comes_from_nothing():
    layer = pad()
    turns = [turn(angle) for angle in (0.01,) * 6 + (-0.01,) * 6]
    steps = marched(layer, lopsided(layer), *turns).steps
    spent = np.cumsum([float(step.work) for step in steps])
    stored = np.array([float(step.energy) for step in steps])
    rubbed = spent - stored
    assert rubbed[0] == pytest.approx(0, abs=2e-2 * stored[0])
    assert np.diff(rubbed).min() > -1e-3 * stored.max()
    assert rubbed[-1] > 0


def test_a_cell_that_leaves_the_contact_is_released():
    pressed, rest = lopsided(LAYER), slid(0.0)
    path = [(pressed, rest), (pressed, turned(0.05)), (pressed - 10, rest)]
    *_, end = march(path, LAYER, TIGHT, friction_coefficient=MU)
    assert not end.traction.any()
    assert float(end.drift_mm.abs().max()) < 1e-12
    assert float(end.indentation_mm.abs().max()) < 1e-12
