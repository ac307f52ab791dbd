"""Whether a camera exposes anew from one frame to the next, and how its pictures compare then.

An exposure that steps changes the whole picture by one gain and one offset for each colour; what
touches or moves changes parts of it. So a step is what gain and offset explain almost all of.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames
from geotlm_lm.recordings.legible import DIM_GREY

Floats = NDArray[np.float32]

SMALL = (40, 30)
"""Columns and rows that exposures are compared at: noise averages out."""

LEAST_GREY = 2.0
"""Change of the middle grey level below which alignment and idle gel follow by themselves."""

STEADY_GREY = 0.5
"""Change below which the exposure is that of before."""

MOST_LEFT = 0.3
"""Share of a change that gain and offset may leave unexplained."""

MOST_GAIN = 2.5
"""Gain beyond which, or below whose inverse, a lens is covered or a lamp flashes."""

PLAIN_GREY = 0.5
"""Deviation of a gel as plain as noise, which tells no gain: all of a change is then offset."""

CLIPPED_GREY = 230.0
"""Level from which a mean may hold pixels at the end of their scale, and tells no gain."""


@dataclass(frozen=True, eq=False)
class Exposure:
    """How grey levels change with a new exposure."""

    gain: Floats  # of red, green and blue, (3,)
    offset_grey: Floats  # likewise, added afterwards, (3,)

    def applied(self, image: NDArray[np.generic]) -> Floats:
        """Return an image (rows, columns, 3) as it would be seen, float32, cut to 0..255."""
        return np.clip(image * self.gain + self.offset_grey, 0, 255, dtype=np.float32)


def small_colours(frame: Frames) -> Floats:
    """Return a frame in the size exposures are compared at, float32, (rows, columns, 3)."""
    return cv2.resize(frame, SMALL, interpolation=cv2.INTER_AREA).astype(np.float32)


def shift_grey(before: Floats, after: Floats) -> float:
    """Return by how much the middle grey level of the colour that changes most has changed."""
    shift = np.median((after - before)[::2, ::2].reshape(-1, 3), axis=0)
    return float(np.abs(shift).max())


def exposure_step(before: Floats, after: Floats) -> Exposure | None:
    """Return the new exposure of the later of two pictures; None where it is that of the earlier.

    Both are as of `small_colours`.
    """
    if shift_grey(before, after) < LEAST_GREY or np.median(after.max(axis=-1)) < DIM_GREY:
        return None
    is_known = (np.maximum(before, after) < CLIPPED_GREY).all(axis=-1)
    if is_known.sum() < is_known.size / 4:
        return None
    earlier, later = before[is_known], after[is_known]
    gain, offset = _compared(earlier, later)
    # What touches may move meanwhile: half of the picture tells the exposure as well.
    left = np.square(later - gain * earlier - offset).sum(axis=1)
    quiet = left <= np.median(left)
    earlier, later = earlier[quiet], later[quiet]
    gain, offset = _compared(earlier, later)
    if not ((gain > 1 / MOST_GAIN) & (gain < MOST_GAIN)).all():
        return None
    left = np.square(later - gain * earlier - offset).sum()
    if left > MOST_LEFT**2 * np.square(later - earlier).sum():
        return None
    return Exposure(gain, offset)


def _compared(earlier: Floats, later: Floats) -> tuple[Floats, Floats]:
    """Return gain and offset of each colour from pixels (n, 3) to the same pixels later.

    Deviations compare as the gain does even where something moves; a regression would shrink it.
    """
    gain = np.hypot(later.std(axis=0), PLAIN_GREY) / np.hypot(earlier.std(axis=0), PLAIN_GREY)
    return gain, later.mean(axis=0) - gain * earlier.mean(axis=0)
