"""Scores over folds: mean and spread, recall of each class, and each object's own accuracy.

Knows no model; arrays and label sequences in, plain JSON values out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.evaluation.scores import (
    Labels,
    accuracy,
    balanced_accuracy,
    mean_by_group,
    recall_per_class,
)
from geotlm_lm.evaluation.splits import Fold
from geotlm_lm.evaluation.uncertainty import clustered_interval


def fold_scores(
    truths: Labels, objects: Labels, folds: Sequence[Fold], predictions: Sequence[Labels]
) -> dict[str, Any]:
    """Return what the paper's tables show of one method, and more.

    Args:
        truths: The truth of every row.
        objects: The object of every row.
        folds: The folds; their test rows are all rows, each once.
        predictions: Fold by fold, what was named for each test row.

    Returns:
        `accuracy` and `balanced` of each fold with mean and standard deviation (n - 1); `recall`,
        the mean over folds of each class; `by_object`, the accuracy of each object where it was
        held out; `interval`, 95 % of the accuracy of all rows, objects resampled.

    Raises:
        ValueError: If there are not as many predictions as test rows.
    """
    truths_of = [[truths[row] for row in fold.test] for fold in folds]
    pairs = list(zip(truths_of, predictions, strict=True))
    overall = [accuracy(*pair) for pair in pairs]
    balanced = [balanced_accuracy(*pair) for pair in pairs]
    right = right_rows(truths, folds, predictions)
    return {
        "accuracy": overall,
        "mean": float(np.mean(overall)),
        "sd": spread(overall),
        "balanced": balanced,
        "balanced_mean": float(np.mean(balanced)),
        "balanced_sd": spread(balanced),
        "recall": _mean_recall([recall_per_class(*pair) for pair in pairs]),
        "by_object": {str(name): share for name, share in mean_by_group(right, objects).items()},
        "interval": list(clustered_interval(right, objects)),
    }


def right_rows(
    truths: Labels, folds: Sequence[Fold], predictions: Sequence[Labels]
) -> NDArray[np.bool_]:
    """Return, row by row, whether the truth was named when the row was held out.

    Raises:
        ValueError: If a row is not tested exactly once.
    """
    tested = np.concatenate([fold.test for fold in folds])
    if not np.array_equal(np.sort(tested), np.arange(len(truths))):
        raise ValueError(
            f"{len(truths)} rows are to be tested once each, found {len(tested)} tests"
        )
    right = np.zeros(len(truths), dtype=bool)
    for fold, named in zip(folds, predictions, strict=True):
        for row, one in zip(fold.test, named, strict=True):
            right[row] = truths[row] == one
    return right


def spread(values: Sequence[float]) -> float:
    """Return the standard deviation over folds, n - 1; 0 for a single one."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0


def _mean_recall(recalls: Sequence[dict]) -> dict[str, float]:
    """Return the mean of each class over the folds that hold it."""
    classes = dict.fromkeys(name for recall in recalls for name in recall)
    return {
        str(name): float(np.mean([recall[name] for recall in recalls if name in recall]))
        for name in classes
    }
