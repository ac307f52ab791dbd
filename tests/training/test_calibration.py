"""Expected values: likelihoods drawn from a known temperature, and separable contact shares."""

from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.training.calibration import (
    SHARES,
    best_share,
    expected_calibration_error,
    fit_contact_threshold,
    fit_temperature,
)
from geotlm_lm.training.labelled import Labelled


@pytest.mark.parametrize("temperature", [0.5, 1.0, 3.0])
def test_the_fitted_temperature_is_the_one_the_truths_were_drawn_from(temperature):
    rng = np.random.default_rng(0)
    scores = rng.normal(size=(6000, 5)) * 3
    gumbel = rng.gumbel(size=scores.shape)
    truths = (scores / temperature + gumbel).argmax(axis=1)  # a draw from the softmax
    assert fit_temperature(scores, truths) == pytest.approx(temperature, rel=0.1)


def test_the_threshold_lies_between_untouched_and_touched_clips():
    share = np.r_[np.linspace(0.0, 0.02, 50), np.linspace(0.08, 0.5, 50)]
    threshold = fit_contact_threshold(share, np.arange(100) >= 50)
    assert 0.02 < threshold < 0.08


def test_where_shares_overlap_contact_is_not_missed():
    share = np.r_[np.linspace(0.0, 0.3, 500), np.linspace(0.1, 0.5, 500)]
    threshold = fit_contact_threshold(share, np.arange(1000) >= 500)
    assert np.mean(share[500:] < threshold) <= 0.01


def test_the_error_is_the_gap_weighted_by_how_often_it_is_met():
    # Three answers stated at 0.9, one of them right (gap 0.9 - 1/3); one at 0.5, right (gap 0.5).
    confidence, is_right = [0.9, 0.9, 0.9, 0.5], [True, False, False, True]
    expected = (3 * (0.9 - 1 / 3) + 0.5) / 4
    assert expected_calibration_error(confidence, is_right) == pytest.approx(expected)
    # Too sure and too unsure do not cancel.
    assert expected_calibration_error([1.0, 0.0], [False, True]) == 1.0


def test_the_share_that_reads_most_is_the_best():
    questions = [Labelled(text, ("turn",)) for text in "abcd"]
    right = dict(zip(SHARES, ("ab", "abc", "a", ""), strict=True))

    def reader_of(share):
        lines = {text: "turn" if text in right[share] else "slide" for text in "abcd"}
        return SimpleNamespace(read=lambda text: SimpleNamespace(line=lines[text]))

    assert best_share(reader_of, questions) == (0.8, {1.0: 0.5, 0.8: 0.75, 0.6: 0.25, 0.4: 0.0})
