import numpy as np
import pytest

from geotlm_lm.simulation.smooth_field import smooth_field


@pytest.mark.parametrize("correlation_px", [0.5, 3.0, 20.0])
def test_a_field_has_unit_moments_and_its_size(correlation_px):
    field = smooth_field(np.random.default_rng(1), 400, correlation_px)
    assert field.shape == (400, 400)
    assert field.mean() == pytest.approx(0, abs=0.05)
    assert field.std() == pytest.approx(1, abs=0.05)


def test_neighbours_within_the_correlation_length_agree_and_far_ones_do_not():
    field = smooth_field(np.random.default_rng(1), 400, 20.0)
    near, far = (np.mean(field[:, :-gap] * field[:, gap:]) for gap in (4, 80))
    assert near > 0.85
    assert abs(far) < 0.2
