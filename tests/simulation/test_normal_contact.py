"""Expected values: Hertz, the thin bonded layer, and the laws a contact must obey."""

import numpy as np
import pytest
import torch

from geotlm_lm.simulation.elastic import LayerOperator
from geotlm_lm.simulation.normal_contact import ROUNDS, solve_normal_contact

SIDE, BOX = 48, 25.6


def grid(side=SIDE, box=BOX):
    axis = (np.arange(side) + 0.5 - side / 2) * box / side
    return np.meshgrid(axis, axis)


def overlap(height, depth):
    return torch.tensor(depth - np.asarray(height), dtype=torch.float32)[None]


def layer(thickness_mm=4.0, poisson_ratio=0.48, side=SIDE, box=BOX, shear_modulus=1.0):
    return LayerOperator(
        side,
        box,
        thickness_mm=thickness_mm,
        poisson_ratio=poisson_ratio,
        shear_modulus=shear_modulus,
    )


def rough(seed=0):
    x, y = grid()
    rng = np.random.default_rng(seed)
    return (x**2 + y**2) / 30 + 0.1 * np.abs(rng.standard_normal(x.shape))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_pressure_is_never_tensile_and_acts_only_where_the_gap_is_closed(seed):
    gap_open = overlap(rough(seed), 0.6)
    contact = solve_normal_contact(gap_open, layer())
    gap = contact.indentation_mm - gap_open
    assert float(contact.pressure.min()) >= 0
    assert float(gap.min()) > -5e-3
    work = float((contact.pressure * gap).abs().sum() / (contact.pressure.sum() * 0.6))
    assert work < 5e-3
    assert contact.status().is_converged


@pytest.mark.parametrize("depth", [0.0, -0.3])
def test_without_overlap_everything_is_exactly_zero(depth):
    x, y = grid()
    contact = solve_normal_contact(overlap(np.hypot(x, y) ** 2, depth), layer())
    assert not contact.pressure.any()
    assert not contact.indentation_mm.any()
    assert contact.status().penetration_um == 0


def test_a_sample_is_solved_alike_alone_and_beside_harder_ones():
    x, y = grid()
    cases = [overlap(rough(), 0.4), overlap(np.zeros_like(x), 1.2), overlap(x**2 + y**2, 0.0)]
    together = solve_normal_contact(torch.cat(cases), layer())
    alone = solve_normal_contact(cases[0], layer())
    assert torch.allclose(together.pressure[0], alone.pressure[0], atol=1e-4)
    assert not together.pressure[2].any()


def test_a_hard_case_gets_more_iterations_and_an_unsolved_one_is_not_called_solved(monkeypatch):
    gap_open, thin = overlap(rough(4) * 3, 3.5), layer(0.3, 0.5)
    generous = solve_normal_contact(gap_open, thin).status()
    assert generous.iterations > ROUNDS[0]
    monkeypatch.setattr("geotlm_lm.simulation.normal_contact.ROUNDS", (1,))
    starved = solve_normal_contact(gap_open, thin).status()
    assert starved.iterations == 1
    assert starved.penetration_um > 30
    assert not starved.is_converged
