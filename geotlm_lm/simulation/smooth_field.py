"""Smooth random fields of unit variance; knows no units."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def smooth_field(rng: np.random.Generator, side: int, correlation_px: float) -> NDArray[np.float32]:
    """Return a random field, mean 0 and standard deviation 1.

    Coarse normal numbers enlarged by cubic interpolation: a tenth of the cost of filtering.

    Args:
        rng: Source of the numbers.
        side: Pixels per side of the result.
        correlation_px: Distance of the coarse numbers, about the correlation length.
    """
    coarse = int(np.ceil(side / max(correlation_px, 1.0))) + 3
    numbers = rng.standard_normal((coarse, coarse), dtype=np.float32)
    enlarged = round(coarse * correlation_px) if correlation_px > 1 else coarse
    field = cv2.resize(numbers, (enlarged, enlarged), interpolation=cv2.INTER_CUBIC)
    row, column = rng.integers(0, max(enlarged - side, 0) + 1, 2)
    field = field[row : row + side, column : column + side]
    # Every fourth sample gives the moments of a field this smooth, at a tenth of the cost.
    some = field[::4, ::4] if side > 64 else field
    mean, size = float(some.mean()), max(float(some.std()), 1e-6)
    return cv2.addWeighted(field, 1 / size, field, 0, -mean / size)
