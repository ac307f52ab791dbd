"""Expected values: closed-form limits of a bonded layer (Johnson, Contact Mechanics)."""

import numpy as np
import pytest

from geotlm_lm.simulation.elastic import grid_compliance, normal_compliance


def compliance(k, nu, h=4.0, **options):
    return normal_compliance(np.array([k]), thickness_mm=h, poisson_ratio=nu, **options)[0]


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.48, 0.5])
def test_short_waves_see_a_half_space(nu):
    k = 30.0
    assert compliance(k, nu) == pytest.approx((1 - nu) / k, rel=1e-6)


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


def test_a_stiffer_layer_yields_in_proportion():
    assert compliance(0.7, 0.48, shear_modulus=1e4) == pytest.approx(1e-4 * compliance(0.7, 0.48))


def test_every_mode_of_the_grid_yields_and_none_overflows():
    values = grid_compliance(48, 25.6, thickness_mm=40.0, poisson_ratio=0.499)
    assert values.shape == (48, 25)
    assert np.all(np.isfinite(values))
    assert values.min() > 0
