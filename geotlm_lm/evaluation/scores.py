"""Accuracies of label sequences: overall, per class, per object, and who was taken for whom.

Knows no model and no clip; a prediction of None (no usable answer) is wrong, never left out.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

Labels = Sequence[Hashable]


def correctness(truths: Labels, predictions: Labels) -> NDArray[np.bool_]:
    """Return, clip by clip, whether the prediction is the truth.

    Raises:
        ValueError: If the lengths differ, or there is no clip.
    """
    if len(truths) != len(predictions) or not len(truths):
        raise ValueError(
            f"expected as many predictions as truths, at least one; found {len(predictions)} "
            f"and {len(truths)}"
        )
    return np.array([a == b for a, b in zip(truths, predictions, strict=True)], dtype=bool)


def accuracy(truths: Labels, predictions: Labels) -> float:
    """Return the share of clips answered right."""
    return float(correctness(truths, predictions).mean())


def recall_per_class(truths: Labels, predictions: Labels) -> dict[Hashable, float]:
    """Return, for each class among the truths, the share of its clips answered right."""
    return mean_by_group(correctness(truths, predictions), truths)


def balanced_accuracy(truths: Labels, predictions: Labels) -> float:
    """Return the mean of the per-class recalls; a one-class answerer gets 1 / classes."""
    return float(np.mean(list(recall_per_class(truths, predictions).values())))


def macro_accuracy(truths: Labels, predictions: Labels, objects: Labels) -> float:
    """Return the mean over objects of each object's accuracy."""
    return float(np.mean(list(mean_by_group(correctness(truths, predictions), objects).values())))


def mean_by_group(values: NDArray, groups: Labels) -> dict[Hashable, float]:
    """Return the mean of `values` in each group, groups in order of first appearance."""
    codes, names = group_codes(groups)
    sums = np.bincount(codes, weights=values, minlength=len(names))
    return dict(zip(names, (sums / np.bincount(codes)).tolist(), strict=True))


def group_codes(groups: Labels) -> tuple[NDArray[np.intp], list[Hashable]]:
    """Number the groups in order of first appearance; return each row's number and the names."""
    numbers: dict[Hashable, int] = {}
    codes = [numbers.setdefault(group, len(numbers)) for group in groups]
    return np.array(codes, dtype=np.intp), list(numbers)


def confusion(truths: Labels, predictions: Labels, labels: Labels) -> NDArray[np.int64]:
    """Count which truth was answered with which label.

    Args:
        truths: One label per clip, each among `labels`.
        predictions: One per clip; anything that is not among `labels` counts as "no answer".
        labels: The order of rows and columns.

    Returns:
        Shape (labels, labels + 1): rows are truths, the last column is "no answer".

    Raises:
        ValueError: If a truth is not among `labels`, or the lengths differ.
    """
    correctness(truths, predictions)
    order = {label: index for index, label in enumerate(labels)}
    strangers = [truth for truth in truths if truth not in order]
    if strangers:
        raise ValueError(f"truths outside the given labels: {strangers[0]}")
    counts = np.zeros((len(order), len(order) + 1), dtype=np.int64)
    for truth, prediction in zip(truths, predictions, strict=True):
        counts[order[truth], order.get(prediction, len(order))] += 1
    return counts
