"""Noise of unit strength, a camera's or a video codec's, cropped from large banks."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE

BANK_PIXELS = 1024**2
"""Numbers in the bank, in one line; a crop begins at one of 998,400 places and lies in one piece:
a window of a square bank, a page of memory per row, takes two and a half times as long to read."""

BANK_SEED = 20260101

CODED_ROWS = 1200
"""Rows of the codec's bank, as wide as an image; its crops begin at one of 218,624 places."""

CODED_BLUR_PX = 1.7
"""Blotches of a codec's noise, standard deviation of a Gaussian: neighbours correlate to 0.92, and
to the measured 0.56 once only what exceeds half a grey level is left."""

CODED_SHARED = 0.87
"""Share of that noise's variance that all channels have in common; the measured correlation of R
and B is 0.48 once rounded."""


def unit_noise(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return white noise of standard deviation 1, float32 (224, 224), read-only."""
    return _crop(_bank(), rng)[0]


def coded_noise(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return noise as a video codec leaves it, float32 (3, 224, 224), read-only.

    Standard deviation 1; neighbouring pixels and the channels are alike.
    """
    return _crop(_coded_bank(), rng)


def _crop(bank: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return images (planes, 224, 224) from a random place of a bank of lines (planes, numbers)."""
    start = int(rng.integers(bank.shape[1] - IMAGE_SIDE**2))
    return bank[:, start : start + IMAGE_SIDE**2].reshape(-1, IMAGE_SIDE, IMAGE_SIDE)


@cache
def _coded_bank() -> NDArray[np.float32]:
    rng = np.random.default_rng(BANK_SEED + 1)
    white = rng.standard_normal((4, CODED_ROWS, IMAGE_SIDE), dtype=np.float32)
    soft = np.stack([_blurred_along(plane, CODED_BLUR_PX) for plane in white])
    soft /= soft.std(axis=1, keepdims=True)
    bank = np.sqrt(CODED_SHARED) * soft[:1] + np.sqrt(1 - CODED_SHARED) * soft[1:]
    bank = bank.astype(np.float32)
    bank.setflags(write=False)
    return bank


def _blurred_along(plane: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    """Return the rows of `plane`, blurred, in one line.

    A row goes on in the next one, so that an image may begin anywhere in the line.
    """
    columns = cv2.GaussianBlur(plane, (1, 0), sigmaX=sigma_px, sigmaY=sigma_px)
    return cv2.GaussianBlur(columns.reshape(1, -1), (0, 1), sigmaX=sigma_px, sigmaY=sigma_px)[0]


@cache
def _bank() -> NDArray[np.float32]:
    bank = np.random.default_rng(BANK_SEED).standard_normal((1, BANK_PIXELS), dtype=np.float32)
    bank.setflags(write=False)
    return bank
