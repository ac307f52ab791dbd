"""Decoded images as RGB of 8 bits, with the decoders kept silent."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import UnreadableClip

AS_STORED = cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH
"""Three colours, in as many bits as the file has: a decoder that is left to reduce them takes the
upper 8 of 16, of which a camera of 10 or 12 bits fills none or few."""

FULL_RANGE_FROM = 2**14
"""Value in 16 bits from which an image is taken to use their range; cameras of 10 to 14 bits stay
below it."""


def rgb_of_8_bits(decoded: Sequence[NDArray[np.generic]], name: str) -> list[Frames]:
    """Return images of one file as uint8 RGB, shape (rows, columns, 3) each.

    Args:
        decoded: In the decoder's order of colours, blue first, as `AS_STORED` gives them.
        name: Of the file, for errors.

    Raises:
        UnreadableClip: As of `of_8_bits`.
    """
    # The one place where a decoded image's order of colours is turned around.
    return [cv2.cvtColor(image, cv2.COLOR_BGR2RGB) for image in of_8_bits(decoded, name)]


def of_8_bits(decoded: Sequence[NDArray[np.generic]], name: str) -> list[Frames]:
    """Return images of one file as uint8: the upper bits, where they have 16.

    Args:
        decoded: Of any number of channels.
        name: Of the file, for errors.

    Raises:
        UnreadableClip: If the values are none of 8 bits, and none of 16 that use their range.
    """
    [kind, *others] = {image.dtype for image in decoded}
    if others or kind not in (np.uint8, np.uint16):
        raise UnreadableClip(
            f"{name}: holds values of type {kind}, expected 8 or 16 bits; scale the frames to "
            f"0..255 and save them in 8 bits."
        )
    if kind == np.uint16:
        require_full_range(max(int(image.max(initial=0)) for image in decoded), name)
        return [(image >> 8).astype(np.uint8) for image in decoded]
    return list(decoded)


def require_full_range(largest: int, name: str) -> None:
    """Refuse 16-bit values that stay too low to use their range, as those of 12-bit cameras do.

    Args:
        largest: Of the values.
        name: Of the file, for errors.

    Raises:
        UnreadableClip: If they do.
    """
    if largest < FULL_RANGE_FROM:
        raise UnreadableClip(
            f"{name}: holds 16-bit values up to {largest}, expected 8 bits, or 16 that are "
            f"used up to {2**16 - 1}; scale the frames to 0..255 and save them in 8 bits."
        )


@contextmanager
def quiet_decoders() -> Iterator[None]:
    """Keep OpenCV's decoders silent, which write to stderr on their own.

    What is wrong with a file is told in one sentence by whoever reads it.
    """
    loudness = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(loudness)
