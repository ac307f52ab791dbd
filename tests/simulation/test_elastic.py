"""Expected values: limits of a bonded layer, and Love's and Cerruti's closed forms of a half-space.

All are in Johnson, Contact Mechanics, 3.2 and 3.6.
"""

import numpy as np
import pytest
import torch
from scipy.linalg import expm

from geotlm_lm.simulation.elastic import HalfSpaceOperator, LayerOperator, layer_spectra
from geotlm_lm.simulation.solvers import cell_centres


def compliance(k, nu, h=4.0, **options):
    spectra = layer_spectra(np.array([k]), thickness_mm=h, poisson_ratio=nu, **options)
    return spectra.zz[0]


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.48])
def test_a_uniform_pressure_compresses_the_layer_in_one_dimension(nu):
    h = 4.0
    expected = h * (1 - 2 * nu) / (2 * (1 - nu))
    assert compliance(0.0, nu) == pytest.approx(expected)
    assert compliance(1e-4, nu) == pytest.approx(expected, rel=1e-4)


def test_long_waves_on_an_incompressible_layer_follow_the_thin_film_law():
    h, k = 4.0, 0.01
    assert compliance(k, 0.5) == pytest.approx(k**2 * h**3 / 3, rel=1e-2)
    assert compliance(0.0, 0.5) == 0.0


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_every_mode_of_the_grid_yields_and_none_overflows(nu):
    k = np.hypot(*np.meshgrid(np.fft.rfftfreq(48) * 48, np.fft.fftfreq(48) * 48)) * 2 * np.pi / 25.6
    for thickness in (0.3, 40.0):
        spectra = layer_spectra(k, thickness_mm=thickness, poisson_ratio=nu)
        for values in (spectra.zz, spectra.ll, spectra.tt, spectra.lz):
            assert values.shape == (48, 25)
            assert np.all(np.isfinite(values))
        assert spectra.zz[k > 0].min() > 0
        assert min(spectra.ll.min(), spectra.tt.min()) > 0


def boundary_value_problem(k, nu, h, pressure, drag):
    """Integrate equilibrium through the layer: (u_l, u_z) at its surface; z points into the gel.

    State (u_l, u_z, s_lz, s_zz) of a plane wave exp(i k l); bonded where z = h.
    """
    lame = 2 * nu / (1 - 2 * nu)
    stiff = lame + 2
    field = np.array(
        [
            [0, -1j * k, 1, 0],
            [-1j * k * lame / stiff, 0, 0, 1 / stiff],
            [(stiff - lame**2 / stiff) * k**2, 0, 0, -1j * k * lame / stiff],
            [0, 0, -1j * k, 0],
        ]
    )
    through = expm(field * h)
    stress = np.array([-drag, -pressure], complex)
    return np.linalg.solve(through[:2, :2], -through[:2, 2:] @ stress)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.48, 0.499])
@pytest.mark.parametrize("k", [0.05, 0.4, 1.5])
def test_the_closed_form_solves_the_boundary_value_problem(nu, k):
    h = 4.0
    spectra = layer_spectra(np.array([k]), thickness_mm=h, poisson_ratio=nu)
    zz, ll, lz = (float(values[0]) for values in (spectra.zz, spectra.ll, spectra.lz))
    pressed = boundary_value_problem(k, nu, h, pressure=1, drag=0)
    dragged = boundary_value_problem(k, nu, h, pressure=0, drag=1)
    assert pressed == pytest.approx(np.array([-1j * lz, zz]), rel=1e-9, abs=1e-9)
    assert dragged == pytest.approx(np.array([ll, 1j * lz]), rel=1e-9, abs=1e-9)


def fields(side=24, seed=0):
    generator = torch.Generator().manual_seed(seed)
    draw = {"generator": generator, "dtype": torch.float64}
    return torch.randn(1, side, side, **draw), torch.randn(1, 2, side, side, **draw)


def operator(nu=0.49, side=24, **options):
    size = {"thickness_mm": 1.5, "poisson_ratio": nu, "dtype": torch.float64}
    return LayerOperator(side, 12.0, **size | options)


def test_a_mirrored_load_moves_the_mirrored_surface():
    pressure, traction = fields(25)
    layer = operator(side=25)
    flipped = traction.flip(3) * torch.tensor([-1.0, 1.0]).view(1, 2, 1, 1)
    moved = layer.shear(flipped).flip(3) * torch.tensor([-1.0, 1.0]).view(1, 2, 1, 1)
    assert torch.allclose(moved, layer.shear(traction), atol=1e-12)
    assert torch.allclose(layer.bulge(flipped).flip(2), layer.bulge(traction), atol=1e-12)


def test_a_uniform_drag_shears_the_layer_by_its_thickness():
    traction = torch.zeros(1, 2, 24, 24, dtype=torch.float64)
    traction[:, 1] = 0.2
    moved = operator(shear_modulus=2.0).shear(traction)
    assert torch.allclose(moved[:, 1], torch.tensor(0.2 * 1.5 / 2, dtype=torch.float64))
    assert float(moved[:, 0].abs().max()) < 1e-12


SIDE, BOX = 33, 6.6


def half_space(nu):
    return HalfSpaceOperator(SIDE, BOX, poisson_ratio=nu)


def square(width_cells):
    load = torch.zeros(1, SIDE, SIDE, dtype=torch.float64)
    low = (SIDE - width_cells) // 2
    load[:, low : low + width_cells, low : low + width_cells] = 1
    return load


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_a_uniform_square_sinks_as_love_says(nu):
    # In the middle of a square of side L: (1 - nu) p / (2 pi G) * 4 L ln(1 + sqrt 2).
    width = 11 * BOX / SIDE
    sunk = half_space(nu).press(square(11))[0, SIDE // 2, SIDE // 2]
    expected = (1 - nu) / (2 * np.pi) * 4 * width * np.log(1 + np.sqrt(2))
    assert float(sunk) == pytest.approx(expected, rel=1e-12)


def test_far_from_a_load_only_its_force_counts():
    nu, cell = 0.3, BOX / SIDE
    force = cell**2
    x, y = cell_centres(SIDE, cell, torch.float64)
    r = torch.hypot(x, y)
    far = r > 15 * cell
    load = square(1)
    sunk = half_space(nu).press(load)[0][far]
    assert sunk.numpy() == pytest.approx(
        ((1 - nu) * force / (2 * np.pi * r[far])).numpy(), rel=2e-3
    )
    drawn = half_space(nu).spread(load)[0, 0][far]
    expected = -(1 - 2 * nu) * force * x[far] / (4 * np.pi * r[far] ** 2)
    assert drawn.numpy() == pytest.approx(expected.numpy(), rel=2e-3, abs=1e-9)
    drag = torch.stack([load, 0 * load], dim=1)
    along = half_space(nu).shear(drag)[0, 0][far]
    expected = force / (2 * np.pi * r[far]) * ((1 - nu) + nu * x[far] ** 2 / r[far] ** 2)
    assert along.numpy() == pytest.approx(expected.numpy(), rel=2e-3)


def test_an_incompressible_half_space_does_not_couple():
    assert float(half_space(0.5).spread(square(5)).abs().max()) < 1e-15


@pytest.mark.parametrize("made", [operator, lambda: operator(side=25), lambda: half_space(0.2)])
def test_what_drag_lifts_pressure_spreads(made):
    """Betti: the work of either load on the other's displacement is the same."""
    body = made()
    pressure, traction = fields(body.side)
    lifted = (body.bulge(traction) * pressure).sum()
    spread = (body.spread(pressure) * traction).sum()
    assert float(lifted) == pytest.approx(float(spread), rel=1e-10)
    assert abs(float(spread)) > 1e-3


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_short_waves_on_a_layer_are_a_half_spaces(nu):
    k = 30.0
    spectra = layer_spectra(np.array([k]), thickness_mm=4.0, poisson_ratio=nu)
    assert spectra.ll[0] == pytest.approx((1 - nu) / k, rel=1e-6)
    assert spectra.tt[0] == pytest.approx(1 / k, rel=1e-6)
    assert spectra.lz[0] == pytest.approx(-(1 - 2 * nu) / (2 * k), rel=1e-6, abs=1e-9)
