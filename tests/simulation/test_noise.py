import numpy as np
import pytest

from geotlm_lm.simulation.noise import unit_noise


def test_noise_has_unit_variance_and_no_memory_from_pixel_to_pixel():
    noise = unit_noise(np.random.default_rng(1))
    assert noise.shape == (224, 224)
    assert noise.mean() == pytest.approx(0, abs=0.02)
    assert noise.std() == pytest.approx(1, abs=0.02)
    assert np.corrcoef(noise[:, 1:].ravel(), noise[:, :-1].ravel())[0, 1] == pytest.approx(
        0, abs=0.02
    )


def test_two_draws_are_unrelated():
    rng = np.random.default_rng(1)
    assert np.corrcoef(unit_noise(rng).ravel(), unit_noise(rng).ravel())[0, 1] == pytest.approx(
        0, abs=0.02
    )
