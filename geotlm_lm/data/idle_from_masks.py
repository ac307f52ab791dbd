"""The idle gel behind recordings that are in contact from their first frame to their last.

No frame of TactileTracking shows the untouched gel, but contact masks say where it is untouched:
each pixel's median over such frames, of all trials, is the gel. Knows masks, not how they came.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames
from geotlm_lm.recordings.idle import estimate_background

MARGIN_SHARE = 0.04
"""Margin around a contact that does not count as untouched, relative to the image's width: the gel
bends beside what touches it, and NormalFlow's masks are eroded."""

ROWS_AT_ONCE = 16
"""Rows of the image that are worked on together: bounds memory with thousands of frames."""


@dataclass(frozen=True, eq=False)
class MaskedFrames:
    """Some frames of one recording.

    Args:
        frames: uint8, shape (t, rows, columns, 3).
        touched: bool, shape (t, rows, columns).
    """

    frames: Frames
    touched: NDArray[np.bool_]

    def untouched(self) -> NDArray[np.bool_]:
        """Return where the gel is surely untouched, shape (t, rows, columns)."""
        side = 2 * max(round(MARGIN_SHARE * self.frames.shape[2]), 1) + 1
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
        return np.stack([cv2.dilate(one.astype(np.uint8), kernel) == 0 for one in self.touched])


@dataclass(frozen=True, eq=False)
class IdleGel:
    """The idle gel of a set of recordings.

    Args:
        image: float32, shape (rows, columns, 3), grey levels.
        gains: Light of each recording relative to it, shape (recordings, 3).
        covered_share: Share of the image touched in every frame, where the shading was fitted.
    """

    image: NDArray[np.float32]
    gains: NDArray[np.float32]
    covered_share: float

    def of(self, recording: int) -> Frames:
        """Return the idle gel of one recording, uint8, shape (rows, columns, 3)."""
        return np.clip(np.rint(self.image * self.gains[recording]), 0, 255).astype(np.uint8)


def idle_from_masks(recordings: Sequence[MaskedFrames]) -> IdleGel:
    """Estimate the idle gel that all `recordings` share, and how their light differs.

    Args:
        recordings: One size of frames; at least one recording.
    """
    untouched = [one.untouched() for one in recordings]
    gains = np.ones((len(recordings), 3), np.float32)
    for _ in range(2):  # the second median is free of differences of light
        image, count = _masked_median(recordings, untouched, gains)
        for index, (one, free) in enumerate(zip(recordings, untouched, strict=True)):
            gains[index] = _gain(one.frames, image, free & (count > 0))
    covered = count == 0
    if covered.any():
        everything = np.concatenate([one.frames for one in recordings])
        image[covered] = estimate_background(everything)[covered]
    return IdleGel(image, gains, float(covered.mean()))


def _masked_median(
    recordings: Sequence[MaskedFrames],
    untouched: Sequence[NDArray[np.bool_]],
    gains: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return each pixel's median where untouched, and in how many frames that is."""
    rows, columns = recordings[0].frames.shape[1:3]
    image = np.zeros((rows, columns, 3), np.float32)
    count = np.sum([free.sum(axis=0) for free in untouched], axis=0)
    for top in range(0, rows, ROWS_AT_ONCE):
        band = slice(top, top + ROWS_AT_ONCE)
        values = np.concatenate(
            [
                np.where(free[:, band, :, None], one.frames[:, band] / gain, np.inf)
                for one, free, gain in zip(recordings, untouched, gains, strict=True)
            ]
        )
        values.sort(axis=0)  # what is touched sorts behind everything
        middle = np.maximum(count[band] - 1, 0) // 2
        found = np.take_along_axis(values, middle[None, :, :, None], axis=0)[0]
        image[band] = np.where(count[band][..., None] > 0, found, 0)
    return image, count


def _gain(
    frames: Frames, image: NDArray[np.float32], free: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """Return each channel's light relative to `image` where the gel is untouched, shape (3,)."""
    own = np.array([frames[..., channel][free].sum(dtype=np.float64) for channel in range(3)])
    usual = np.array([(image[..., channel] * free).sum(dtype=np.float64) for channel in range(3)])
    known = (own > 0) & (usual > 0)
    return np.where(known, own / np.where(known, usual, 1), 1).astype(np.float32)
