"""What stated probabilities are worth: Brier score, and risk against coverage.

Knows neither answers nor models.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def brier_score(confidence: NDArray[np.floating], is_right: NDArray[np.bool_]) -> float:
    """Return the mean squared distance of confidence to what came true.

    Args:
        confidence: Stated probability of each answer, in [0, 1], shape (n,), n >= 1.
        is_right: Whether the answer was right, shape (n,).

    Raises:
        ValueError: If the shapes differ or there is no answer.
    """
    confidence, is_right = _checked(confidence, is_right)
    return float(np.square(confidence - is_right).mean())


def risk_coverage(
    confidence: NDArray[np.floating], is_right: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return coverages and the share of wrong answers at each, the surest answers kept first.

    Answers of equal confidence are kept or dropped together, so that no order of theirs is better
    than another: at a coverage inside such a group its mean risk holds for each of its members.

    Returns:
        Coverage k / n and risk among the k surest, k = 1 ... n, shape (n,) each.

    Raises:
        ValueError: As in `brier_score`.
    """
    confidence, is_right = _checked(confidence, is_right)
    order = np.argsort(-confidence, kind="stable")
    _, group = np.unique(-confidence[order], return_inverse=True)
    wrong = 1.0 - is_right[order]
    mean_of_group = np.bincount(group, weights=wrong) / np.bincount(group)
    kept = np.arange(1, len(order) + 1)
    return kept / len(order), np.cumsum(mean_of_group[group]) / kept


def area_under_risk_coverage(
    confidence: NDArray[np.floating], is_right: NDArray[np.bool_]
) -> float:
    """Return the mean risk over all coverages (AURC); 0 where no answer is wrong.

    Raises:
        ValueError: As in `brier_score`.
    """
    return float(risk_coverage(confidence, is_right)[1].mean())


def coverage_at(
    confidence: NDArray[np.floating], is_right: NDArray[np.bool_], accuracy: float
) -> float:
    """Return the largest share of answers whose accuracy is at least `accuracy`; 0 if none is.

    Raises:
        ValueError: As in `brier_score`.
    """
    coverage, risk = risk_coverage(confidence, is_right)
    reached = coverage[risk <= 1.0 - accuracy + 1e-12]
    return float(reached.max(initial=0.0))


def _checked(confidence: NDArray, is_right: NDArray) -> tuple[NDArray, NDArray]:
    confidence, is_right = np.asarray(confidence, float), np.asarray(is_right, float)
    if confidence.shape != is_right.shape or not confidence.size:
        raise ValueError(f"shapes differ or are empty: {confidence.shape}, {is_right.shape}")
    return confidence, is_right
