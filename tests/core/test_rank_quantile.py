"""Expected values: the numbers sorted."""

import numpy as np
import pytest

from geotlm_lm.core.numbers import quantile_by_rank


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.99])
@pytest.mark.parametrize("kind", [np.float32, np.int16])
def test_the_value_is_the_one_at_its_place_among_the_sorted(share, kind):
    values = np.random.default_rng(0).integers(-99, 99, (37, 41)).astype(kind)[::2, ::3]
    assert quantile_by_rank(values, share) == np.sort(values.ravel())[int(share * values.size)]


def test_half_is_the_upper_median():
    assert quantile_by_rank(np.array([4.0, 1.0, 3.0, 2.0])) == 3.0


@pytest.mark.parametrize(("share", "value"), [(0.0, -3), (0.2, -3), (0.25, 1), (0.7, 1), (0.99, 8)])
def test_a_share_of_four_values_written_out(share, value):
    assert quantile_by_rank(np.array([[8, 1], [-3, 1]]), share) == value


@pytest.mark.parametrize(("values", "share"), [([], 0.5), ([1.0], 1.0), ([1.0], -0.1)])
def test_no_value_and_no_share_are_refused(values, share):
    with pytest.raises(ValueError, match="expected some, 0 <= share < 1"):
        quantile_by_rank(np.array(values), share)


def test_the_values_stay_in_their_places():
    values = np.array([3.0, 1.0, 2.0])
    quantile_by_rank(values)
    assert values.tolist() == [3.0, 1.0, 2.0]
