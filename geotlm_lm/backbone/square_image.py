"""Resample a picture less the idle gel to the square that the patch grid divides."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE

Floats = NDArray[np.float32]


def to_square(frame: NDArray[np.uint8], idle: NDArray[np.uint8], filled: tuple[int, int]) -> Floats:
    """Return a frame less the idle gel, grey levels, as a 224-pixel square.

    Args:
        frame: uint8 RGB.
        idle: The idle gel, of the same size.
        filled: Rows and columns of the square that the picture fills.
    """
    residual = _resized(frame, idle, filled)
    down, right = ((IMAGE_SIDE - side) // 2 for side in filled)
    if not (down or right):
        return residual
    return cv2.copyMakeBorder(residual, down, down, right, right, cv2.BORDER_CONSTANT, value=0)


def _resized(frame: NDArray[np.uint8], idle: NDArray[np.uint8], filled: tuple[int, int]) -> Floats:
    """Return a frame less the idle gel, grey levels, resized to rows and columns."""
    rows, columns = frame.shape[:2]
    how = cv2.INTER_AREA if max(rows, columns) > IMAGE_SIDE else cv2.INTER_LINEAR
    size = filled[::-1]
    if rows % filled[0] == 0 and columns % filled[1] == 0:
        # OpenCV averages whole squares of bytes in a tenth of the time.
        frame, idle = (cv2.resize(one, size, interpolation=how) for one in (frame, idle))
        return cv2.subtract(frame, idle, dtype=cv2.CV_32F)
    # Elsewhere subtracted first, so that the idle gel is not resized: at 640 x 480 it takes three
    # quarters of the time; only at 3840 x 2160 half again as much.
    return cv2.resize(cv2.subtract(frame, idle, dtype=cv2.CV_32F), size, interpolation=how)
