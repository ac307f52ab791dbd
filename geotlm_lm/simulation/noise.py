"""Camera noise: unit white noise cropped from one large bank; knows no grey levels."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE

BANK_SIDE = 1024
"""Side of the bank; a crop begins at one of 640,000 places, and cropping costs a twentieth of
drawing fresh numbers, measured."""

BANK_SEED = 20260101


def unit_noise(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return white noise of standard deviation 1, float32 (224, 224), read-only."""
    row, column = rng.integers(0, BANK_SIDE - IMAGE_SIDE, 2)
    return _bank()[row : row + IMAGE_SIDE, column : column + IMAGE_SIDE]


@cache
def _bank() -> NDArray[np.float32]:
    bank = np.random.default_rng(BANK_SEED).standard_normal((BANK_SIDE,) * 2, dtype=np.float32)
    bank.setflags(write=False)
    return bank
