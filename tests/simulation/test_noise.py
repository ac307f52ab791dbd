import numpy as np
import pytest

from geotlm_lm.simulation.noise import CODED_BLUR_PX, coded_noise, unit_noise


def test_noise_has_unit_variance_and_no_memory_from_pixel_to_pixel():
    noise = unit_noise(np.random.default_rng(1))
    assert noise.shape == (224, 224)
    assert noise.mean() == pytest.approx(0, abs=0.02)
    assert noise.std() == pytest.approx(1, abs=0.02)
    assert np.corrcoef(noise[:, 1:].ravel(), noise[:, :-1].ravel())[0, 1] == pytest.approx(
        0, abs=0.02
    )


def test_a_codecs_noise_is_as_soft_along_rows_as_across_them():
    noise = np.stack([coded_noise(np.random.default_rng(seed))[0] for seed in range(8)])
    along = np.corrcoef(noise[:, :, 1:].ravel(), noise[:, :, :-1].ravel())[0, 1]
    across = np.corrcoef(noise[:, 1:].ravel(), noise[:, :-1].ravel())[0, 1]
    # White noise behind a Gaussian correlates as exp(-d^2 / 4 sigma^2) over a distance d.
    expected = np.exp(-1 / (4 * CODED_BLUR_PX**2))
    assert (along, across) == pytest.approx((expected, expected), abs=0.01)
