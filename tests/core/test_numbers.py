"""Named generators repeat and differ; quantiles are those of the sorted numbers."""

import numpy as np
import pytest

from geotlm_lm.core.numbers import generator_for, median, quantile_by_rank, seed_for


def test_root_names_and_order_all_matter():
    seeds = [
        seed_for(7, "a", "b"),
        seed_for(7, "b", "a"),
        seed_for(7, "a"),
        seed_for(8, "a", "b"),
        seed_for(7, "a", 1),
        seed_for(7, "a", 2),
    ]
    assert len(set(seeds)) == len(seeds)
    assert seed_for(7, "a", 1) == seeds[4]
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_neighbouring_clips_are_uncorrelated():
    first, second = (generator_for(0, "clip", index).random(4000) for index in (0, 1))
    # The correlation of 4000 independent pairs has a standard deviation of 0.016.
    assert abs(((first - 0.5) * (second - 0.5)).mean() * 12) < 0.08


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.99])
@pytest.mark.parametrize("kind", [np.float32, np.int16])
def test_the_value_is_the_one_at_its_place_among_the_sorted(share, kind):
    values = np.random.default_rng(0).integers(-99, 99, (37, 41)).astype(kind)[::2, ::3]
    before = values.copy()
    assert quantile_by_rank(values, share) == np.sort(values.ravel())[int(share * values.size)]
    assert np.array_equal(values, before)


@pytest.mark.parametrize(("values", "share"), [([], 0.5), ([1.0], 1.0), ([1.0], -0.1)])
def test_no_value_and_no_share_are_refused(values, share):
    with pytest.raises(ValueError, match="expected some, 0 <= share < 1"):
        quantile_by_rank(np.array(values), share)


@pytest.mark.parametrize("count", [1, 8, 9])
def test_the_median_is_numpys(count):
    values = np.random.default_rng(count).normal(size=(3, count)).astype(np.float32)
    assert median(values).tolist() == np.median(values, axis=-1).tolist()
