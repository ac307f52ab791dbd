"""How far a contact has turned since some frames that are kept, by what light does not change.

Steps from frame to frame come out short: a lit flank changes as it turns under the lamps, and the
outline of what is round stands still. So a frame is kept every few degrees, as the magnitude of its
imprint over the colours, high-passed, which is the same under any lamp; each new one is compared
with several kept before, at every angle about the one that the steps tell and at every shift.

The angle since the first kept frame is a density on a grid. Steps are its prior. Each comparison is
a likelihood, of the form that a correlation c of n independent pixels has under Gaussian noise,
(1 - c^2)^(-n/2), mixed with one that says nothing: what rolls, bends or repeats itself has no match
or a false one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.search import correlations
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.geometry import camera_size
from geotlm_lm.track.events import MOST_SHARE, SURE_SHARE
from geotlm_lm.track.keyframes import Step

Floats = NDArray[np.float32]
Angles = NDArray[np.floating]

COLUMNS = 80
"""Width of the pictures compared: of real turns of half `tune` 64 to 160 tell 0.98 within a tenth,
and the time grows as the square."""

FINE_PX, COARSE_PX = 0.35, 2.0
"""Deviations of the Gaussian bells between which detail is compared, pixels of that width."""

APART_DEG, APART_S = 12.0, 0.3
"""Turn, or time, after which the next frame is kept."""

TURNING_DEG, ALIKE = 4.0, 0.9
"""After that time only where steps tell more than this, or where the picture is less alike than
that: steps hold still what a fixed mark outshines."""

GROWN, STILL_DEG = 1.1, 3.0
"""Growth of an imprint's strength from which on, where it has not turned farther than this, a frame
takes the place of the only one kept: a contact that begins shows little."""

FARTHEST_DEG, COMPARED = 90.0, 4
"""Turn over which frames are compared, and how many kept ones a frame is compared with."""

GRID_DEG = 2.0
"""Step of the grid of angles."""

PIXELS = 120.0
"""Independent pixels of a picture. On half `tune` 80 to 200 tell as well; of 20 little is left of a
comparison, and the steps' bias stays."""

FALSE_SHARE = 0.15
"""Share of comparisons that say nothing."""

STEPS_SHARE, STEPS_DEG = 0.4, 2.0
"""Deviation of what steps tell between two kept frames, as a share, and at the least."""

LOST_SHARE, LOST_DEG = 0.1, 15.0
"""Share of steps that tell nothing of a turn, and its deviation then."""

REACH, LOST_REACH = 4.0, 2.5
"""Deviations of either within which angles are compared."""

MATCHING = 0.6
"""Likeness of two frames from which on steps were not lost: what stands still is less alike."""

PADDED = 32
"""What sides with room for shifts are multiples of: transforms of 96 x 128 take two thirds of the
time of 90 x 120."""

CLEARLY, CLEARLY_DEG = 2.0, 3.0
"""Deviations, and degrees, from which on a turn is believed that steps do not show at all."""


class Turn(NamedTuple):
    """How far it has turned since the frame kept last."""

    beyond_deg: float  # what the steps since then add up to
    share: float  # of the turn that is doubted


@dataclass(frozen=True, eq=False)
class _Kept:
    picture: Floats
    mean_deg: float
    deviation_deg: float


def detail_of(frame: Frames, gel: Frames) -> Floats:
    """Return what is compared of a frame, float32, `COLUMNS` wide, pixels square on the gel.

    The gel is what to take off it, as of `without_dots`.
    """
    rows, columns = camera_size(*frame.shape[:2])
    size = (2 * COLUMNS, max(round(2 * COLUMNS * rows / columns), 16))
    seen, gel = (
        cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        for image in (frame, gel)
    )
    change = cv2.GaussianBlur(seen - gel, (0, 0), 2 * FINE_PX)
    strength = np.sqrt(np.square(change).sum(axis=-1))
    detail = cv2.GaussianBlur(strength, (0, 0), 2 * FINE_PX)
    detail -= cv2.GaussianBlur(strength, (0, 0), 2 * COARSE_PX)
    small = cv2.resize(detail, (COLUMNS, size[1] // 2), interpolation=cv2.INTER_AREA)
    return small - small.mean()


class KeyAngles:
    """Follows the turn of one contact, frame by frame."""

    def __init__(self) -> None:
        self._kept: list[_Kept] = []
        self._mean_deg = self._variance = 0.0  # since the first kept frame
        self._since_deg = 0.0  # turn by steps since the last kept one
        self._kept_s = self._strength_grey = 0.0  # when that was taken, and its imprint's strength

    def follow(
        self,
        step: Step,
        time_s: float,
        strength_grey: float,
        detail: Callable[[], Floats],
        *,
        is_due: bool = False,
    ) -> Turn | None:
        """Take in the next frame and return how the steps were mended, if they were.

        Args:
            step: From the frame before.
            time_s: When it was taken.
            strength_grey: Of the imprint.
            detail: Makes what is compared of the frame, as `detail_of` does, where it is needed.
            is_due: Whether these steps are mended now or never: a turn is compared earlier then.
        """
        self._since_deg += float(step.twist[0])
        since_deg = abs(self._since_deg)
        is_grown = strength_grey > GROWN * self._strength_grey
        if not self._kept or len(self._kept) == 1 and is_grown and since_deg < STILL_DEG:
            self._kept, self._strength_grey = [], strength_grey
            self._keep(detail(), 0.0, 0.0, time_s)
            return None
        is_due |= since_deg >= APART_DEG or time_s - self._kept_s >= APART_S
        if not is_due:
            return None
        picture = detail()
        if since_deg < TURNING_DEG and _alike(self._kept[-1].picture, picture) > ALIKE:
            self._kept_s = time_s
            return None
        return self._compared(picture, time_s)

    def _compared(self, picture: Floats, time_s: float) -> Turn | None:
        steps_deg = abs(self._since_deg)
        own = self._variance + (STEPS_SHARE * steps_deg) ** 2
        deviation = math.hypot(math.sqrt(own), STEPS_DEG)
        prior = self._mean_deg + self._since_deg
        mean, own = self._posterior(picture, prior, deviation)
        beyond = mean - prior
        if steps_deg < TURNING_DEG and abs(beyond) < max(CLEARLY * own, CLEARLY_DEG):
            self._kept_s = time_s
            return None
        self._keep(picture, mean, own, time_s)
        share = math.hypot(SURE_SHARE, own / max(abs(mean), APART_DEG))
        return Turn(beyond, min(share, MOST_SHARE))

    def _keep(self, picture: Floats, mean_deg: float, deviation_deg: float, time_s: float) -> None:
        # What has come back to an angle is seen as it looks now.
        near = [kept for kept in self._kept if abs(kept.mean_deg - mean_deg) >= APART_DEG / 4]
        near = [kept for kept in near if abs(kept.mean_deg - mean_deg) <= FARTHEST_DEG]
        self._kept = [*near, _Kept(picture, mean_deg, deviation_deg)]
        self._mean_deg, self._variance, self._since_deg = mean_deg, deviation_deg**2, 0.0
        self._kept_s = time_s

    def _posterior(
        self, picture: Floats, prior_deg: float, prior_deviation_deg: float
    ) -> tuple[float, float]:
        """Return mean and deviation of the angle."""
        places = np.linspace(0, len(self._kept) - 1, COMPARED).round().astype(int)
        kept = [self._kept[place] for place in np.unique(places)]
        for reach in (REACH * prior_deviation_deg, LOST_REACH * LOST_DEG):
            count = math.ceil(reach / GRID_DEG)
            angles = prior_deg + np.arange(-count, count + 1) * GRID_DEG
            alike = [_likeness(each, picture, angles) for each in kept]
            if alike[-1].max() > MATCHING:
                break
        shown, lost = (
            np.exp(-0.5 * np.square((angles - prior_deg) / deviation)) / deviation
            for deviation in (prior_deviation_deg, LOST_DEG)
        )
        logs = np.log((1 - LOST_SHARE) * shown + LOST_SHARE * lost)
        even = FALSE_SHARE / (len(angles) * GRID_DEG)
        for each, likeness in zip(kept, alike, strict=True):
            density = _density(likeness, each.deviation_deg)
            logs += np.log((1 - FALSE_SHARE) * density + even)
        chances = np.exp(logs - logs.max())
        chances /= chances.sum()
        mean = float(chances @ angles)
        own = float(chances @ np.square(angles - mean)) + GRID_DEG**2 / 12
        return mean, math.sqrt(own)


def _alike(before: Floats, after: Floats) -> float:
    """Return how alike two pictures are where they lie."""
    return float((before * after).sum() / (np.linalg.norm(before) * np.linalg.norm(after) + 1e-6))


def _likeness(kept: _Kept, picture: Floats, angles_deg: Angles) -> Angles:
    """Return how alike two frames are at each angle, at the best shift, (n,)."""
    turns = np.radians(angles_deg - kept.mean_deg).astype(np.float32)
    padded = tuple(PADDED * math.ceil(1.5 * side / PADDED) for side in picture.shape)
    alike = correlations(kept.picture, picture, turns, padded)
    return alike.reshape(len(turns), -1).max(axis=1).clip(0, 0.999)


def _density(likeness: Angles, deviation_deg: float) -> Angles:
    """Return how probable each angle is by one comparison, per degree, (n,).

    The deviation is that of the kept frame's own angle.
    """
    logs = -0.5 * PIXELS * np.log1p(-np.square(likeness))
    density = np.exp(logs - logs.max())
    half = (len(density) - 1) // 2
    off = np.arange(-half, half + 1) * GRID_DEG
    bell = np.exp(-0.5 * np.square(off / max(deviation_deg, GRID_DEG / 5)))
    density = np.convolve(density, bell / bell.sum(), mode="same")
    return density / (density.sum() * GRID_DEG)
