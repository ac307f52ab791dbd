"""Whether anything touches the gel at all: how far the frames are from the idle one."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip

COLUMNS = 160
"""Width the change is measured at; it averages four pixels of a 320-pixel stream."""

BLUR_PX = 2.0
"""Blur of the change, in pixels of that width: camera noise averages out, an imprint does not."""

TOUCHED_SHARE = 0.01
"""Share of the image that a touch changes at the least: the contact mask of the smallest readable
imprint has 0.005, and the gel bends around it."""

UNTOUCHED_GREY = 1.5
"""Change below which nothing touches. Of 1,309 simulated touches of training objects the faintest
is at 1.8, the next at 3.2; 71 % of the untouched clips among them are below, and 220 of 221 idle
starts of real recordings, whose faintest turn is at 4.2."""

UNTOUCHED_PROBABILITY = 0.997
"""That a clip below it is untouched: 95 % bound from no touch among 1,309 (rule of three)."""

FAINT_GREY = 1.2
"""Change up to which an idle gel may differ from itself without noise, as codecs and lamps make it:
219 of 221 idle starts of real recordings stay below, 95 % of them below 0.8."""

BEYOND_NOISE = 40.0
"""Change in units of the noise from which on it is no noise. Simulated untouched clips reach 12,
real recordings without a visible contact 26; touches a twentieth as strong as usual have 68 in the
middle, unless a noise as strong as usual hides them."""

NOISE_FLOOR_GREY = 0.02
"""Noise assumed at the least: a codec repeats pixels that hardly change."""

BORDER_SHARE = 0.05
"""Width of the image's border relative to its width."""

CUT_OFF = 1.5
"""Strength of the change along a border, relative to the whole image's, from which on an imprint is
cut off there. Simulated contacts anywhere in the image are below, and 92 % of real windows; half of
those moved half out of the image are above 1.8."""


def change_from_idle_grey(clip: Clip) -> float:
    """Return how far the most changed hundredth of the image is from the idle gel, grey levels.

    The largest over the frames, in green, which a video codec keeps best; a change of exposure does
    not count.

    Args:
        clip: Frames of any size with a background.

    Raises:
        ValueError: If the clip has no background.
    """
    if clip.background is None:
        raise ValueError("the change is measured against an idle frame, found none")
    idle = _small(clip.background)
    return max(_changed(_small(frame) - idle) for frame in clip.frames)


def is_beyond_noise(clip: Clip, change_grey: float) -> bool:
    """Tell whether a change from the idle gel, however faint, is none of the camera's noise.

    Args:
        clip: The frames that changed.
        change_grey: What `change_from_idle_grey` found.
    """
    if change_grey < FAINT_GREY:
        return False
    frames = [_small(frame) for frame in clip.frames]
    steps = [after - before for before, after in pairwise(frames) if np.any(after != before)]
    noise = min(map(_noise_grey, steps), default=0.0)
    return change_grey > BEYOND_NOISE * max(noise, NOISE_FLOOR_GREY)


def is_cut_off(clip: Clip) -> bool:
    """Tell whether the border of the image cuts through what changed against the idle gel.

    Args:
        clip: Frames of any size with a background.
    """
    idle = _small(clip.background)
    change = np.max([np.abs(_small(frame) - idle) for frame in clip.frames], axis=0)
    width = max(round(BORDER_SHARE * change.shape[1]), 1)
    sides = (change[:, :width], change[:, -width:], change[:width], change[-width:])
    strongest = max(float(np.square(side).mean()) for side in sides)
    return strongest > CUT_OFF**2 * float(np.square(change).mean())


def _noise_grey(step: NDArray[np.float32]) -> float:
    """Return the deviation of one frame's noise, at the width the change is measured at."""
    fine = step - cv2.GaussianBlur(step, (0, 0), BLUR_PX)
    # The median of a normal deviation's size is 0.6745; two frames' noise adds up in a step.
    return float(np.median(np.abs(fine))) / (0.6745 * 2**0.5)


def _changed(change: NDArray[np.float32]) -> float:
    smooth = cv2.GaussianBlur(change - np.median(change), (0, 0), BLUR_PX)
    return float(np.quantile(np.abs(smooth), 1 - TOUCHED_SHARE))


def _small(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    green = np.ascontiguousarray(image[..., 1])
    columns = min(COLUMNS, image.shape[1])
    rows = max(round(image.shape[0] * columns / image.shape[1]), 1)
    return cv2.resize(green, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float32)
