"""Expected values: Hertz, the thin bonded layer, and the laws a contact must obey."""

import numpy as np
import pytest
import torch

from geotlm_lm.simulation.elastic import LayerOperator, layer_spectra
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


def test_a_ball_on_a_thick_layer_needs_the_force_of_hertz():
    # G = 1: E* = 2 G / (1 - nu); F = 4/3 E* sqrt(R) d^(3/2). The layer is 40 mm thick, the contact
    # 1.4 mm wide on cells of 0.13 mm; grid and box leave a few per cent.
    radius, depth, nu, side, box = 4.0, 0.1, 0.3, 96, 12.8
    x, y = grid(side, box)
    contact = solve_normal_contact(
        overlap((x**2 + y**2) / (2 * radius), depth), layer(40.0, nu, side, box)
    )
    force = float(contact.pressure.sum()) * (box / side) ** 2
    # The periodic box adds the layer's uniform compression and leaves out the far field of a lone
    # force: 3.900 / L is the lattice sum of 1 / r over a square lattice with its mean removed.
    uniform = layer_spectra(np.zeros(1), thickness_mm=40, poisson_ratio=nu).zz[0]
    sinking = force / box**2 * uniform
    far_field = 3.9 * (1 - nu) * force / (2 * np.pi * box)
    expected = 4 / 3 * 2 / (1 - nu) * radius**0.5 * (depth - sinking + far_field) ** 1.5
    assert force == pytest.approx(expected, rel=0.03)


def test_a_wide_ball_on_a_thin_compressible_layer_acts_as_a_winkler_bed():
    # F = pi R d^2 / h * 2 G (1 - nu) / (1 - 2 nu) for a >> h.
    radius, depth, thickness, nu = 200.0, 0.1, 0.4, 0.3
    x, y = grid()
    contact = solve_normal_contact(
        overlap((x**2 + y**2) / (2 * radius), depth), layer(thickness, nu)
    )
    force = float(contact.pressure.sum()) * (BOX / SIDE) ** 2
    expected = np.pi * radius * depth**2 / thickness * 2 * (1 - nu) / (1 - 2 * nu)
    assert force == pytest.approx(expected, rel=0.05)


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


def test_a_stiffer_layer_takes_more_pressure_and_the_same_shape():
    gap_open = overlap(rough(), 0.5)
    soft, stiff = (
        solve_normal_contact(gap_open, layer(shear_modulus=modulus)) for modulus in (1.0, 1e4)
    )
    assert torch.allclose(stiff.pressure, 1e4 * soft.pressure, rtol=1e-3, atol=1.0)
    assert torch.allclose(stiff.indentation_mm, soft.indentation_mm, atol=1e-4)


def test_a_mirrored_body_leaves_the_mirrored_imprint():
    gap_open = overlap(rough(3), 0.5)
    plain = solve_normal_contact(gap_open, layer())
    mirrored = solve_normal_contact(gap_open.flip(2), layer())
    assert torch.allclose(mirrored.indentation_mm.flip(2), plain.indentation_mm, atol=1e-4)


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
