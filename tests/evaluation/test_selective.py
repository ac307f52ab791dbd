"""Expected values are counted by hand; the laws hold for any scores."""

import numpy as np
import pytest

from geotlm_lm.evaluation.selective import (
    area_under_risk_coverage,
    brier_score,
    coverage_at,
    risk_coverage,
)

CONFIDENCE = np.array([0.9, 0.5, 0.8, 0.2])
IS_RIGHT = np.array([True, True, False, False])


def test_the_brier_score_is_the_mean_squared_distance():
    assert brier_score(CONFIDENCE, IS_RIGHT) == pytest.approx((0.01 + 0.25 + 0.64 + 0.04) / 4)


def test_a_coin_that_knows_it_is_one_scores_a_quarter():
    assert brier_score(np.full(6, 0.5), np.arange(6) % 2 == 0) == 0.25


def test_the_surest_answers_are_kept_first():
    coverage, risk = risk_coverage(CONFIDENCE, IS_RIGHT)
    np.testing.assert_allclose(coverage, [0.25, 0.5, 0.75, 1.0])
    np.testing.assert_allclose(risk, [0.0, 1 / 2, 1 / 3, 1 / 2])


def test_the_area_is_the_mean_risk():
    expected = (0 + 1 / 2 + 1 / 3 + 1 / 2) / 4
    assert area_under_risk_coverage(CONFIDENCE, IS_RIGHT) == pytest.approx(expected)


def test_equal_confidence_gives_the_mean_risk_at_every_coverage_whatever_the_order():
    for is_right in (IS_RIGHT, IS_RIGHT[::-1]):
        _, risk = risk_coverage(np.full(4, 0.7), is_right)
        np.testing.assert_allclose(risk, 0.5)


def test_sorting_by_truth_is_the_best_and_against_it_the_worst_area():
    rng = np.random.default_rng(0)
    is_right = rng.random(200) < 0.7
    best, worst = (
        area_under_risk_coverage(np.where(is_right, a, b), is_right)
        for a, b in ((0.9, 0.1), (0.1, 0.9))
    )
    middle = area_under_risk_coverage(rng.random(200), is_right)
    assert best < middle < worst


def test_coverage_is_the_largest_share_that_is_accurate_enough():
    # Kept 1, 2, 3, 4: accuracies 1, 1/2, 2/3, 1/2.
    assert coverage_at(CONFIDENCE, IS_RIGHT, 1.0) == 0.25
    assert coverage_at(CONFIDENCE, IS_RIGHT, 0.6) == 0.75
    assert coverage_at(CONFIDENCE, IS_RIGHT, 0.5) == 1.0
    assert coverage_at([0.9], [False], 0.5) == 0.0


@pytest.mark.parametrize("function", [brier_score, risk_coverage, area_under_risk_coverage])
def test_no_answer_is_refused(function):
    with pytest.raises(ValueError, match="empty"):
        function([], [])
