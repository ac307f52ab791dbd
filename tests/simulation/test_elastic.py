"""Expected values: closed-form limits of a bonded layer (Johnson, Contact Mechanics)."""

import numpy as np
import pytest
import torch
from scipy.linalg import expm

from geotlm_lm.simulation.elastic import LayerOperator, layer_spectra


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


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_short_waves_shear_and_couple_as_on_a_half_space(nu):
    k = 30.0
    spectra = layer_spectra(np.array([k]), thickness_mm=4.0, poisson_ratio=nu)
    assert spectra.ll[0] == pytest.approx((1 - nu) / k, rel=1e-6)
    assert spectra.tt[0] == pytest.approx(1 / k, rel=1e-6)
    assert spectra.lz[0] == pytest.approx(-(1 - 2 * nu) / (2 * k), rel=1e-6, abs=1e-9)


def fields(side=24, seed=0):
    generator = torch.Generator().manual_seed(seed)
    draw = {"generator": generator, "dtype": torch.float64}
    return torch.randn(1, side, side, **draw), torch.randn(1, 2, side, side, **draw)


def operator(nu=0.49, side=24, **options):
    size = {"thickness_mm": 1.5, "poisson_ratio": nu, "dtype": torch.float64}
    return LayerOperator(side, 12.0, **size | options)


@pytest.mark.parametrize("side", [24, 25])
def test_what_drag_lifts_pressure_spreads(side):
    """Betti: the work of either load on the other's displacement is the same."""
    pressure, traction = fields(side)
    layer = operator(side=side)
    lifted = (layer.bulge(traction) * pressure).sum()
    spread = (layer.spread(pressure) * traction).sum()
    assert float(lifted) == pytest.approx(float(spread), rel=1e-10)
    assert abs(float(spread)) > 1e-3


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


def test_an_incompressible_pad_is_pushed_outwards_and_a_compressible_one_drawn_in():
    """Near-incompressible layers couple with the opposite sign of the half-space's."""
    pressure = torch.zeros(1, 24, 24, dtype=torch.float64)
    pressure[:, 10:14, 10:14] = 1
    right_of_it = (0, 0, 12, 17)
    assert float(operator(nu=0.49).spread(pressure)[right_of_it]) > 0
    thick = operator(nu=0.0, thickness_mm=40.0)
    assert float(thick.spread(pressure)[right_of_it]) < 0
