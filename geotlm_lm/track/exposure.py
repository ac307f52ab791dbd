"""The idle gel of a stream, learnt while nothing touches, and how a camera exposes it.

An exposure that steps changes the whole picture by one gain and one offset for each colour; what
touches or moves changes parts of it. So a step is what gain and offset explain almost all of.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.dots import activity_grey, is_marked
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.numbers import median
from geotlm_lm.recordings.idle import (
    FAINT_IMPRINT,
    activity_colours,
    band_pass,
    lost_share,
    texture_lost,
)
from geotlm_lm.recordings.legible import DIM_GREY, MOST_OFFSET_GREY

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

LEARNING_FRAMES = 5
"""Frames that must agree before they are taken for the idle gel: 0.2 s of a GelSight Mini."""

STEADY_FRAMES = 15
"""Frames that must agree before a lifted object is believed: a hand does not rest that still."""

CHANGING_FRAMES = 10
"""Frames over which a change of light adds up to a new exposure: a slower one is followed."""

LIFTED_SHARE = 0.75
"""Share of a change that is lost structure, from which on the stream is taken to have started
touched: 0 for a touch, 1/2 for a moved object, 1 for a lifted one."""

SAMPLED = 8
"""Of so many rows and columns one is looked at to compare exposures."""

FOLLOWING, MARKED_FOLLOWING = 0.02, 0.05
"""Weight of a new untouched frame: light that drifts over a few seconds is followed. The dots of a
gel creep besides."""

OWN_NOISE = 1.9
"""Imprint of a gel with dots from which on it is touched, in units of the noise from one frame to
the next. Five real recordings that are noisy pass it within two frames of their touch; where the
gel is learnt from the first frames, two of six do so four or five frames early."""

NOISE_FRAMES = 5
"""Steps whose median tells the noise; the least one so far counts, as of a gel at rest."""

MOST_NOISE = 1.5
"""Of a camera that shows a gel: the noisiest of these has 0.8."""

FIRST_NOISE = 0.6
"""Share of the finest noise in a picture that is as wide as an imprint, where no step is known."""

AGREEING = 1.6
"""Most that frames differ from their middle in units of that noise; what moves steadily, 2.8."""


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
    change = (after - before)[::2, ::2].reshape(-1, 3)
    return float(np.abs(median(change.T)).max())


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


class IdleTracker:
    """Learns the idle gel and measures every frame against it.

    A gel that is known already is followed as the light drifts.
    """

    def __init__(self, idle: Frames | None = None) -> None:
        self._recent: deque[tuple[Frames, Floats]] = deque(maxlen=STEADY_FRAMES)
        self._steps: deque[float] = deque(maxlen=NOISE_FRAMES)
        self._noise: float | None = None
        self._is_marked = False
        self._idle: Floats | None = None
        self._small: Floats | None = None
        self._colours: Floats | None = None
        """A frame that is exposed as the idle gel is, as exposures are compared."""
        self._reference_age = 0
        self.is_exposed_alike = True
        """Whether the frame followed last is about as bright as the idle gel: no flash, no cap."""
        if idle is not None:
            # Contiguous: OpenCV changes it in place.
            self._idle = np.ascontiguousarray(idle, np.float32)
            self._is_marked = is_marked(activity_grey(idle[None]))
            self._small = self._picture(idle)
            self._colours = small_colours(idle)

    @property
    def background(self) -> Frames | None:
        """The idle gel, uint8, shape (rows, columns, 3); None while it is being learnt."""
        return None if self._idle is None else np.rint(self._idle).astype(np.uint8)

    def follow_exposure(self, frame: Frames) -> Exposure | None:
        """Return how a frame is exposed anew, if it is; the idle gel is then taken to be so too."""
        self.is_exposed_alike = True
        if self._idle is None or frame.shape != self._idle.shape:
            return None
        colours = small_colours(frame)
        step = None if self._colours is None else exposure_step(self._colours, colours)
        if step is not None:
            self._idle = np.ascontiguousarray(step.applied(self._idle))
            self._small = self._picture(self._idle)
            # Frames before and after do not agree with each other any more.
            self._recent.clear()
        few = (slice(None, None, SAMPLED), slice(None, None, SAMPLED))
        shift_of_frame = float(median((frame[few] - self._idle[few]).ravel()))
        self.is_exposed_alike = abs(shift_of_frame) <= MOST_OFFSET_GREY
        if self.is_exposed_alike and self._is_new_reference(colours, step):
            self._colours, self._reference_age = colours, 0
        self._reference_age += 1
        return step

    def _is_new_reference(self, colours: NDArray[np.float32], step: Exposure | None) -> bool:
        """Tell whether later frames are compared with this one: not while the light changes."""
        if step is not None or self._colours is None or self._reference_age > CHANGING_FRAMES:
            return True
        return shift_grey(self._colours, colours) < STEADY_GREY

    def strength(self, frame: Frames) -> float | None:
        """Take in the next frame and return its imprint; None while the gel is being learnt.

        It is the grey levels (rms) between the frame and the idle gel. On a gel with dots that is
        noisy it is less: as many times `FAINT_IMPRINT` as it is stronger than the noise allows.

        Raises:
            UnreadableClip: If it is of another size than the frames before.
        """
        self._require_same_size(frame)
        if self._idle is None:
            is_dotted = is_marked(activity_grey(frame[None]))
            if is_dotted != self._is_marked:
                self._is_marked = is_dotted
                self._recent.clear()
        small = self._picture(frame)
        self._take_noise(small)
        self._recent.append((frame, small))
        if self._idle is None:
            if self._agree(LEARNING_FRAMES):
                self._learn(LEARNING_FRAMES)
            else:
                return None
        strength = self._imprint(small)
        least = self.faintest(small)
        if strength > least and self._was_lifted():
            self._learn(STEADY_FRAMES)
            strength = self._imprint(small)
        elif strength < (least if self._is_marked else least / 2):
            # Only clearly untouched frames: a touch that begins faintly must not be learnt away.
            weight = MARKED_FOLLOWING if self._is_marked else FOLLOWING
            cv2.accumulateWeighted(frame, self._idle, weight)
            cv2.accumulateWeighted(small, self._small, weight)
        return strength / least * FAINT_IMPRINT

    def _picture(self, frame: NDArray[np.generic]) -> Floats:
        """Return what imprints are measured in: the dots of a gel hide less of its colours."""
        few = frame[None]
        return activity_colours(few)[0] if self._is_marked else activity_grey(few)[0]

    def _imprint(self, small: Floats, idle: Floats | None = None) -> float:
        """Return how far a picture is from the idle gel, or from another, grey levels (rms)."""
        return _rms(band_pass(small - (self._small if idle is None else idle), self._is_marked))

    def _take_noise(self, small: Floats) -> None:
        """Measure the noise between this frame and the one before."""
        if not self._recent or not self._is_marked:
            return
        self._steps.append(self._imprint(small, self._recent[-1][1]) / 2**0.5)
        if len(self._steps) == NOISE_FRAMES or self._noise is None:
            noise = float(np.median(self._steps))
            self._noise = noise if self._noise is None else min(noise, self._noise)

    def faintest(self, small: Floats) -> float:
        """Return the imprint from which on something touches, grey levels (rms)."""
        if not self._is_marked:
            return FAINT_IMPRINT
        if self._noise is not None:
            return max(FAINT_IMPRINT, OWN_NOISE * self._noise)
        change = small - self._small
        fine = np.abs(change - cv2.GaussianBlur(change, (0, 0), 1.5))
        return max(FAINT_IMPRINT, FIRST_NOISE * 1.48 * float(np.median(fine)))

    def _require_same_size(self, frame: Frames) -> None:
        before = self._recent[-1][0] if self._recent else frame
        before = before if self._idle is None else self._idle
        if frame.shape != before.shape:
            raise UnreadableClip(
                f"A frame of the stream is {frame.shape[1]} x {frame.shape[0]} pixels after "
                f"{before.shape[1]} x {before.shape[0]}, expected one size; keep the camera's "
                f"resolution and start again."
            )

    def _agree(self, count: int) -> bool:
        """Tell whether the last `count` frames show the same."""
        if len(self._recent) < count:
            return False
        recent = [image for _, image in self._recent][-count:]
        most = max(FAINT_IMPRINT, AGREEING * min(self._noise or 0.0, MOST_NOISE))
        # What is as near to one middle is no farther from each other than twice that.
        if self._imprint(recent[0], recent[-1]) >= 2 * most:
            return False
        middle = np.partition(recent, count // 2, axis=0)[count // 2]
        return all(self._imprint(image, middle) < most for image in recent)

    def _was_lifted(self) -> bool:
        """Tell whether what was taken for idle had an object on it, which is gone now."""
        if not self._agree(STEADY_FRAMES):
            return False
        later = np.stack([image for _, image in self._recent])
        if self._is_marked:
            return texture_lost(np.stack([self._small, self._small]), later) > LIFTED_SHARE
        return float(np.median(lost_share(self._small, later))) > LIFTED_SHARE

    def _learn(self, count: int) -> None:
        frames = np.stack([frame for frame, _ in list(self._recent)[-count:]])
        self._idle = np.median(frames, axis=0).astype(np.float32)
        self._small = np.median([image for _, image in list(self._recent)[-count:]], axis=0)


def _rms(image: NDArray[np.float32]) -> float:
    return float(np.sqrt(np.square(image).mean()))
