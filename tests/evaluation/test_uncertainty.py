import itertools

import numpy as np
import pytest
from scipy import stats

from geotlm_lm.evaluation.uncertainty import (
    clustered_interval,
    mcnemar_exact,
    paired_difference,
    sign_flip_p,
)


def correlated_clips(rng, objects=30, clips=20):
    """Clips of one object share its difficulty: a beta-distributed accuracy of mean 0.8."""
    skill = np.repeat(rng.beta(4, 1, objects), clips)
    return rng.random(objects * clips) < skill, np.repeat(np.arange(objects), clips)


def width(interval):
    return interval[1] - interval[0]


def test_clips_of_one_object_widen_the_interval():
    correct, objects = correlated_clips(np.random.default_rng(0))
    naive = clustered_interval(correct, np.arange(len(correct)))
    assert width(clustered_interval(correct, objects)) > 1.5 * width(naive)


def test_independent_clips_get_the_binomial_interval():
    correct = np.random.default_rng(1).random(2000) < 0.7
    error = np.sqrt(correct.mean() * (1 - correct.mean()) / 2000)
    assert width(clustered_interval(correct, np.arange(2000))) == pytest.approx(
        2 * 1.96 * error, rel=0.06
    )


def test_the_interval_covers_the_truth_about_nineteen_times_in_twenty():
    rng = np.random.default_rng(2)
    hits = 0
    for repeat in range(300):
        correct, objects = correlated_clips(rng)
        low, high = clustered_interval(correct, objects, seed=repeat, draws=500)
        hits += low <= 0.8 <= high
    # 300 repeats: standard error 0.013; a naive interval covers about 0.7 here.
    assert 0.89 < hits / 300 < 0.985


def test_all_right_still_leaves_doubt():
    low, high = clustered_interval(np.ones(50, bool), np.arange(50))
    # Wilson's interval at 50 of 50 is (n / (n + z^2), 1).
    assert (low, high) == pytest.approx((50 / (50 + 1.96**2), 1.0), abs=1e-4)
    assert clustered_interval(np.zeros(50, bool), np.arange(50)) == pytest.approx(
        (1 - high, 1 - low)
    )


def test_the_same_seed_gives_the_same_interval():
    correct, objects = correlated_clips(np.random.default_rng(3))
    assert clustered_interval(correct, objects, seed=5) == clustered_interval(
        correct, objects, seed=5
    )


@pytest.mark.parametrize(("right", "count"), [(7, 20), (49, 50), (1, 3)])
def test_one_object_gets_the_interval_of_independent_clips(right, count):
    correct = np.arange(count) < right
    expected = stats.binomtest(right, count).proportion_ci(method="wilson")
    found = clustered_interval(correct, ["cap"] * count)
    assert found == pytest.approx((expected.low, expected.high))


@pytest.mark.parametrize(
    ("only_first", "only_second"), [(0, 0), (1, 0), (9, 2), (30, 45), (900, 870)]
)
def test_mcnemar_is_the_binomial_test_on_clips_that_differ(only_first, only_second):
    first = np.array([True] * only_first + [False] * only_second + [True] * 5)
    second = np.array([False] * only_first + [True] * only_second + [True] * 5)
    differing = only_first + only_second
    expected = stats.binomtest(only_first, differing).pvalue if differing else 1.0
    assert mcnemar_exact(first, second) == pytest.approx(expected)


def test_sign_flips_agree_with_going_through_every_pattern():
    rng = np.random.default_rng(4)
    gain, objects = rng.integers(-1, 2, 40).astype(float), np.arange(40) % 7
    sums = [gain[objects == one].sum() for one in range(7)]
    totals = [abs(np.dot(p, sums)) for p in itertools.product((-1, 1), repeat=7)]
    expected = np.mean([total >= abs(gain.sum()) - 1e-9 for total in totals])
    assert sign_flip_p(gain, objects) == pytest.approx(expected)


def test_sampled_sign_flips_agree_with_the_exact_ones():
    rng = np.random.default_rng(5)
    gain = rng.normal(0.3, 1, 14)
    patterns = np.array(list(itertools.product((-1, 1), repeat=14)))
    exact = (np.abs(patterns @ gain) >= abs(gain.sum()) - 1e-9).mean()
    assert sign_flip_p(gain, np.arange(14)) == pytest.approx(exact, abs=0.03)


def test_one_object_can_never_be_significant():
    found = paired_difference(np.ones(500), np.zeros(500), ["cap"] * 500)
    assert (found.low, found.high, found.p_value) == (-1.0, 1.0, 1.0)


def test_no_real_difference_is_found_about_one_time_in_twenty():
    rng = np.random.default_rng(6)
    found = [
        sign_flip_p(rng.normal(0, 1, 40), np.arange(40), seed=k, draws=400) < 0.05
        for k in range(400)
    ]
    assert np.mean(found) == pytest.approx(0.05, abs=0.03)


def test_the_paired_difference_is_antisymmetric():
    rng = np.random.default_rng(7)
    first, second, objects = rng.random(90) < 0.9, rng.random(90) < 0.7, np.arange(90) % 15
    forth = paired_difference(first, second, objects)
    back = paired_difference(second, first, objects)
    assert forth.difference == pytest.approx(first.mean() - second.mean())
    assert (forth.low, forth.high) == pytest.approx((-back.high, -back.low))
    assert (forth.p_value, forth.mcnemar_p) == (back.p_value, back.mcnemar_p)


def test_the_same_answers_differ_by_nothing():
    same = np.array([True, False] * 20)
    found = paired_difference(same, same, np.arange(40) % 4)
    assert (found.difference, found.low, found.high) == (0, 0, 0)
    assert (found.p_value, found.mcnemar_p) == (1.0, 1.0)


def test_unequal_lengths_are_refused():
    with pytest.raises(ValueError, match="lengths differ: 2, 1, 2"):
        paired_difference(np.ones(2), np.ones(1), ["a", "b"])
