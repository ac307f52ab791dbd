"""Expected values: limits of a bonded layer, and Love's and Cerruti's closed forms of a half-space.

All are in Johnson, Contact Mechanics, 3.2 and 3.6.
"""

import numpy as np
import pytest
import torch
from scipy.linalg import expm

from geotlm_lm.simulation.elastic import HalfSpaceOperator, LayerOperator, layer_spectra
from geotlm_lm.simulation.solvers import cell_centres


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


def operator(side=24):
    return LayerOperator(side, 12.0, thickness_mm=1.5, poisson_ratio=0.49, dtype=torch.float64)


def test_a_uniform_drag_shears_the_layer_by_its_thickness():
    traction = torch.zeros(1, 2, 24, 24, dtype=torch.float64)
    traction[:, 1] = 0.2
    moved = operator().shear(traction)
    assert torch.allclose(moved[:, 1], torch.tensor(0.2 * 1.5, dtype=torch.float64))
    assert float(moved[:, 0].abs().max()) < 1e-12


SIDE, BOX, NU = 33, 6.6, 0.3


def test_far_from_a_load_only_its_force_counts():
    half_space, nu, cell = HalfSpaceOperator(SIDE, BOX, poisson_ratio=NU), NU, BOX / SIDE
    force = cell**2
    x, y = cell_centres(SIDE, cell, torch.float64)
    r = torch.hypot(x, y)
    far = r > 15 * cell
    load = torch.zeros(1, SIDE, SIDE, dtype=torch.float64)
    load[:, SIDE // 2, SIDE // 2] = 1
    sunk = half_space.press(load)[0][far]
    assert sunk.numpy() == pytest.approx(
        ((1 - nu) * force / (2 * np.pi * r[far])).numpy(), rel=2e-3
    )
    drawn = half_space.spread(load)[0, 0][far]
    expected = -(1 - 2 * nu) * force * x[far] / (4 * np.pi * r[far] ** 2)
    assert drawn.numpy() == pytest.approx(expected.numpy(), rel=2e-3, abs=1e-9)
    drag = torch.stack([load, 0 * load], dim=1)
    along = half_space.shear(drag)[0, 0][far]
    expected = force / (2 * np.pi * r[far]) * ((1 - nu) + nu * x[far] ** 2 / r[far] ** 2)
    assert along.numpy() == pytest.approx(expected.numpy(), rel=2e-3)


@pytest.mark.parametrize(
    "made",
    [operator, lambda: operator(side=25), lambda: HalfSpaceOperator(SIDE, BOX, poisson_ratio=0.2)],
)
def test_what_drag_lifts_pressure_spreads(made):
    """Betti: the work of either load on the other's displacement is the same."""
    body = made()
    draw = {"generator": torch.Generator().manual_seed(0), "dtype": torch.float64}
    pressure, traction = (
        torch.randn(1, *some, body.side, body.side, **draw) for some in ((), (2,))
    )
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
