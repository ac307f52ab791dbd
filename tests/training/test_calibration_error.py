import numpy as np
import pytest

from geotlm_lm.training.calibration_error import expected_calibration_error


def test_probabilities_that_come_true_have_next_to_no_error():
    rng = np.random.default_rng(0)
    confidence = rng.uniform(0.2, 1.0, 200_000)
    assert expected_calibration_error(confidence, rng.random(200_000) < confidence) < 0.005


def test_the_error_is_the_gap_weighted_by_how_often_it_is_met():
    # Three answers stated at 0.9, one of them right (gap 0.9 - 1/3); one at 0.5, right (gap 0.5).
    confidence, is_right = [0.9, 0.9, 0.9, 0.5], [True, False, False, True]
    expected = (3 * (0.9 - 1 / 3) + 0.5) / 4
    assert expected_calibration_error(confidence, is_right) == pytest.approx(expected)


def test_too_sure_and_too_unsure_do_not_cancel():
    assert expected_calibration_error([1.0, 0.0], [False, True]) == 1.0
