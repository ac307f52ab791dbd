"""Whether anything touches the gel at all: how far the frames are from the idle one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.numbers import quantile_by_rank

Floats = NDArray[np.float32]

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

FAINT_GREY = 0.8
"""Change up to which an idle gel differs from itself without noise, as codecs and lamps make it:
211 of 221 idle starts of real recordings stay below. Of 200 simulated clips with a twentieth of
their contrast 89 are told as no touch for sure where this bound is 1.2, 36 where it is 0.8, and 24
more are told right."""

CHANGED_GREY = 1.2
"""Change beyond noise above which a gel is not idle: 219 of those 221 starts stay below."""

BEYOND_NOISE = 40.0
"""Change in units of the noise from which on it is no noise. Simulated untouched clips reach 12,
real recordings without a visible contact 26."""

CLEAR_GREY = 4.2
"""Change of the faintest turn among real recordings."""

MAP_SIZE = (24, 32)
"""Rows and columns of a map of the change: what is drawn over a picture need not be finer."""

BORDER_SHARE = 0.05
"""Width of the image's border relative to its width."""

CUT_OFF = 1.5
"""Strength of the change along a border, relative to the whole image's, from which on an imprint is
cut off there. Of 95 simulated contacts one is above, of 91 real windows 8; of those contacts moved
half out of the image seven in ten."""


@dataclass(frozen=True, eq=False)
class Change:
    """How frames differ from the idle gel: green, at the width the change is measured at.

    Of `changes` the idle gel, a change of exposure and noise are taken away.
    """

    frames: tuple[Floats, ...]
    changes: tuple[Floats, ...]

    @cached_property
    def grey(self) -> float:
        """How far the most changed hundredth of the image is from the idle gel, grey levels.

        The largest over the frames, in green, which a video codec keeps best; a change of exposure
        does not count.
        """
        # Smooth over more than two pixels, so that every other one tells as much.
        thinned = (np.abs(change[::2, ::2]) for change in self.changes)
        return max(float(quantile_by_rank(change, 1 - TOUCHED_SHARE)) for change in thinned)

    @cached_property
    def is_beyond_noise(self) -> bool:
        """Whether the change, however faint, is none of the camera's noise.

        Frames that are all the same tell nothing of their noise, and count as noisy.
        """
        if self.grey <= FAINT_GREY:
            return False
        steps = (after - before for before, after in pairwise(self.frames))
        return any(self.grey > BEYOND_NOISE * _noise_grey(step) for step in steps if step.any())

    @property
    def is_faint(self) -> bool:
        """Whether the change is beyond noise, but an idle gel may change as much now and then."""
        return self.is_beyond_noise and self.grey <= CHANGED_GREY

    @property
    def is_cut_off(self) -> bool:
        """Whether the border of the image cuts through what changed."""
        change = np.abs(self.changes[0])
        for other in self.changes[1:]:
            np.maximum(change, np.abs(other), out=change)
        width = max(round(BORDER_SHARE * change.shape[1]), 1)
        sides = (change[:, :width], change[:, -width:], change[:width], change[-width:])
        strongest = max(float(np.square(side).mean()) for side in sides)
        return strongest > CUT_OFF**2 * float(np.square(change).mean())


def change_from_idle(clip: Clip) -> Change:
    """Compare the frames of a clip with its background."""
    if clip.background is None:
        raise ValueError("the change is measured against an idle frame, found none")
    idle = _small(clip.background)
    frames = tuple(map(_small, clip.frames))
    return Change(frames, tuple(_smooth(frame - idle) for frame in frames))


def change_map(frame: Frames, idle: Frames) -> Floats:
    """Return where a frame is imprinted, `MAP_SIZE`: 0 as an idle gel, 1 clearly touched."""
    change = np.abs(_smooth(_small(frame) - _small(idle)))
    few = cv2.resize(change, MAP_SIZE[::-1], interpolation=cv2.INTER_AREA)
    return np.clip((few - UNTOUCHED_GREY) / (CLEAR_GREY - UNTOUCHED_GREY), 0, 1)


def is_static(clip: Clip) -> bool:
    """Tell whether no frame differs from the first by more than an untouched gel may."""
    return change_from_idle(replace(clip, background=clip.frames[0])).grey < UNTOUCHED_GREY


def _noise_grey(step: Floats) -> float:
    """Return the deviation of one frame's noise, at the width the change is measured at."""
    fine = (step - cv2.GaussianBlur(step, (0, 0), BLUR_PX))[::2, ::2]
    # The median of a normal deviation's size is 0.6745; two frames' noise adds up in a step.
    return float(quantile_by_rank(np.abs(fine))) / (0.6745 * 2**0.5)


def _smooth(change: Floats) -> Floats:
    offset = quantile_by_rank(change[::2, ::2])
    return cv2.GaussianBlur(change, (0, 0), BLUR_PX) - offset


def _small(image: NDArray[np.uint8]) -> Floats:
    green = cv2.extractChannel(image, 1)
    columns = min(COLUMNS, image.shape[1])
    rows = max(round(image.shape[0] * columns / image.shape[1]), 1)
    return cv2.resize(green, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float32)
