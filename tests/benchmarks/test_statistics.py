import numpy as np
import pytest
from scipy import stats

from geotlm_lm.benchmarks.statistics import clustered_interval, paired_difference


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
    for repeat in range(150):
        correct, objects = correlated_clips(rng)
        low, high = clustered_interval(correct, objects, seed=repeat)
        hits += low <= 0.8 <= high
    # 150 repeats: standard error 0.018; a naive interval covers about 0.7 here.
    assert 0.89 < hits / 150 < 0.985


def test_all_right_still_leaves_doubt():
    low, high = clustered_interval(np.ones(50, bool), np.arange(50))
    # Wilson's interval at 50 of 50 is (n / (n + z^2), 1).
    assert (low, high) == pytest.approx((50 / (50 + 1.96**2), 1.0), abs=1e-4)
    assert clustered_interval(np.zeros(50, bool), np.arange(50)) == pytest.approx(
        (1 - high, 1 - low)
    )


@pytest.mark.parametrize(("right", "count"), [(7, 20), (49, 50), (1, 3)])
def test_one_object_gets_the_interval_of_independent_clips(right, count):
    correct = np.arange(count) < right
    expected = stats.binomtest(right, count).proportion_ci(method="wilson")
    found = clustered_interval(correct, ["cap"] * count)
    assert found == pytest.approx((expected.low, expected.high))


def test_one_object_can_never_be_significant():
    found = paired_difference(np.ones(500), np.zeros(500), ["cap"] * 500)
    assert (found["low"], found["high"]) == (-1.0, 1.0)


def test_the_paired_difference_is_antisymmetric():
    rng = np.random.default_rng(7)
    first, second, objects = rng.random(90) < 0.9, rng.random(90) < 0.7, np.arange(90) % 15
    forth = paired_difference(first, second, objects)
    back = paired_difference(second, first, objects)
    assert forth["difference"] == pytest.approx(first.mean() - second.mean())
    assert (forth["low"], forth["high"]) == pytest.approx((-back["high"], -back["low"]))
