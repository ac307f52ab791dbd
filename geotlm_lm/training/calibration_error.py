"""Whether stated probabilities come true; knows neither answers nor models."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BINS = 15
"""Equal-width bins, as in Guo et al. 2017 (On Calibration of Modern Neural Networks)."""


def expected_calibration_error(
    confidence: NDArray[np.floating], is_right: NDArray[np.bool_], bins: int = BINS
) -> float:
    """Return the mean gap between confidence and accuracy, bins weighted by their answers.

    Args:
        confidence: Stated probability of each answer, in [0, 1], shape (n,), n >= 1.
        is_right: Whether the answer was right, shape (n,).
        bins: Number of bins.

    Raises:
        ValueError: If the shapes differ or there is no answer.
    """
    confidence, is_right = np.asarray(confidence, float), np.asarray(is_right, float)
    if confidence.shape != is_right.shape or not confidence.size:
        raise ValueError(f"shapes differ or are empty: {confidence.shape}, {is_right.shape}")
    places = np.minimum((confidence * bins).astype(int), bins - 1)
    gaps = np.bincount(places, weights=confidence - is_right, minlength=bins)
    return float(np.abs(gaps).sum() / confidence.size)
