"""Noise of unit strength, a camera's or a video codec's, cropped from large banks."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE

BANK_SIDE = 1024
"""Side of the bank; a crop begins at one of 640,000 places, and cropping costs a twentieth of
drawing fresh numbers, measured."""

BANK_SEED = 20260101

CODED_SIDE = 512
"""Side of the codec's bank; its crops begin at one of 80,000 places."""

CODED_BLUR_PX = 1.7
"""Blotches of a codec's noise, standard deviation of a Gaussian: neighbours correlate to 0.92, and
to the measured 0.56 once only what exceeds half a grey level is left."""

CODED_SHARED = 0.87
"""Share of that noise's variance that all channels have in common; the measured correlation of R
and B is 0.48 once rounded."""


def unit_noise(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return white noise of standard deviation 1, float32 (224, 224), read-only."""
    row, column = rng.integers(0, BANK_SIDE - IMAGE_SIDE, 2)
    return _bank()[row : row + IMAGE_SIDE, column : column + IMAGE_SIDE]


def coded_noise(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return noise as a video codec leaves it, float32 (3, 224, 224), read-only.

    Standard deviation 1; neighbouring pixels and the channels are alike.
    """
    row, column = rng.integers(0, CODED_SIDE - IMAGE_SIDE, 2)
    return _coded_bank()[:, row : row + IMAGE_SIDE, column : column + IMAGE_SIDE]


@cache
def _coded_bank() -> NDArray[np.float32]:
    rng = np.random.default_rng(BANK_SEED + 1)
    white = rng.standard_normal((4, CODED_SIDE, CODED_SIDE), dtype=np.float32)
    soft = np.stack([cv2.GaussianBlur(plane, (0, 0), CODED_BLUR_PX) for plane in white])
    soft /= soft.std(axis=(1, 2), keepdims=True)
    bank = np.sqrt(CODED_SHARED) * soft[:1] + np.sqrt(1 - CODED_SHARED) * soft[1:]
    bank = bank.astype(np.float32)
    bank.setflags(write=False)
    return bank


@cache
def _bank() -> NDArray[np.float32]:
    bank = np.random.default_rng(BANK_SEED).standard_normal((BANK_SIDE,) * 2, dtype=np.float32)
    bank.setflags(write=False)
    return bank
