"""Expected values: counted by hand on twelve rows of four objects."""

import numpy as np
import pytest

from geotlm_lm.evaluation.fold_scores import fold_scores, right_rows, spread
from geotlm_lm.evaluation.splits import Fold

OBJECTS = ["cap", "key", "nut", "pen"] * 3
TRUTHS = ["a", "a", "b", "b"] + ["b", "a", "a", "b"] + ["a", "b", "b", "a"]
NONE = np.array([], dtype=np.intp)
FOLDS = [
    Fold(NONE, NONE, np.array([0, 4, 8, 1, 5, 9]), ("cap", "key")),
    Fold(NONE, NONE, np.array([2, 6, 10, 3, 7, 11]), ("nut", "pen")),
]
PREDICTIONS = [
    ["a", "b", "a", "a", "a", "a"],  # the truths are a b a, a a b: one b is missed
    ["b", "b", "b", "b", None, "b"],  # the truths are b a b, b b a: both a and one b are missed
]


@pytest.fixture
def scores():
    return fold_scores(TRUTHS, OBJECTS, FOLDS, PREDICTIONS)


def test_accuracy_is_given_fold_by_fold_with_mean_and_spread(scores):
    assert scores["accuracy"] == pytest.approx([5 / 6, 3 / 6])
    assert scores["mean"] == pytest.approx(4 / 6)
    assert scores["sd"] == pytest.approx((2 / 6) / np.sqrt(2))  # n - 1


def test_recall_and_balanced_accuracy_are_means_over_folds(scores):
    assert scores["recall"] == pytest.approx({"a": (1 + 0) / 2, "b": (1 / 2 + 3 / 4) / 2})
    assert scores["balanced"] == pytest.approx([0.75, 0.375])
    assert scores["balanced_mean"] == pytest.approx(0.5625)


def test_every_object_is_scored_where_it_was_held_out(scores):
    assert scores["by_object"] == pytest.approx(
        {"cap": 1, "key": 2 / 3, "nut": 2 / 3, "pen": 1 / 3}
    )
    low, high = scores["interval"]
    assert low < 8 / 12 < high


def test_a_class_that_a_fold_lacks_counts_in_the_others_only():
    folds = [Fold(NONE, NONE, np.array([0, 1]), ()), Fold(NONE, NONE, np.array([2, 3]), ())]
    scores = fold_scores(
        ["a", "a", "a", "b"], ["x", "x", "y", "y"], folds, [["a", "a"], ["b", "b"]]
    )
    assert scores["recall"] == {"a": 0.5, "b": 1.0}


def test_a_row_that_is_not_tested_once_is_refused():
    with pytest.raises(ValueError, match="12 rows are to be tested once each, found 6 tests"):
        right_rows(TRUTHS, FOLDS[:1], PREDICTIONS[:1])
    twice = [FOLDS[0], FOLDS[0]]
    with pytest.raises(ValueError, match="found 12 tests"):
        right_rows(TRUTHS, twice, [PREDICTIONS[0]] * 2)


def test_a_single_fold_has_no_spread():
    assert spread([0.3]) == 0.0
