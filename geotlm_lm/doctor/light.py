"""Light: exposure and colours that drift, pixels at the end of their scale, noise."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.doctor.finding import Finding, judged
from geotlm_lm.recordings.legible import DARK_GREY, DIM_GREY, GREEN, WHITE_GREY, noise_grey
from geotlm_lm.track.exposure import exposure_step

Floats = NDArray[np.float32]

MOST_DRIFT_GREY = 6.0
"""Lasting change of the whole picture's level: 65 real recordings that thresholds are chosen by
stay below 1.8, contact and all. From 12 on a clip is refused."""

MOST_BALANCE_GREY = 5.0
"""Lasting change of a colour against the others: the same recordings stay below 2.1, one more that
was looked at has 3.0."""

MOST_CLIPPED = 0.02
"""Share of pixels at an end of the scale; below 0.001 on real recordings, at most 0.01 on
simulated ones."""

MOST_NOISE_GREY = 4.0
"""Noise from which on it costs answers: real recordings have 1.2 at most, simulated ones 2.5."""

SAMPLED = 9
"""Frames that are looked at pixel by pixel."""


def drifts(smalls: Sequence[Floats]) -> list[Finding]:
    """Judge exposure and white balance over the recording.

    Args:
        smalls: Every frame as `small_colours` returns it.
    """
    first = np.median(smalls[:3], axis=0)
    level = np.maximum(np.median(first.reshape(-1, 3), axis=0), 1.0)
    shifts = np.stack([np.median((one - first).reshape(-1, 3), axis=0) for one in smalls])
    drift = _lasting(np.abs(shifts.mean(axis=1)))
    # One gain for all colours or one offset is exposure; what neither explains is balance.
    gain = shifts @ level / (level @ level)
    by_gain = np.ptp(shifts - gain[:, None] * level, axis=1)
    balance = _lasting(np.minimum(by_gain, np.ptp(shifts, axis=1)))
    jumps = sum(exposure_step(*pair) is not None for pair in pairwise(smalls))
    told = f", {jumps} times from one frame to the next" if jumps else ""
    return [
        judged(
            "exposure",
            f"the whole picture's level changes by {drift:.1f} grey levels at most{told}.",
            "Every change of the light looks like a change of the gel: contact is told where none "
            "is, and beyond 12 grey levels within a clip it is refused.",
            "Switch the camera's automatic exposure off and lock its gain.",
            is_fault=drift > MOST_DRIFT_GREY,
        ),
        judged(
            "white balance",
            f"a colour changes against the others by {balance:.1f} grey levels at most.",
            "The gel's colours tell its slopes: imprints seem to change where only colours did.",
            "Switch the camera's automatic white balance off.",
            is_fault=balance > MOST_BALANCE_GREY,
        ),
    ]


def _lasting(values: Floats) -> float:
    """Return what one frame in fifty is beyond: a large object passes by, a drift stays."""
    return float(np.quantile(values, 0.98))


def pixels(clip: Clip) -> list[Finding]:
    """Judge brightness, clipping and noise."""
    chosen = np.unique(np.linspace(0, len(clip) - 1, SAMPLED).round().astype(int))
    frames = clip.frames[chosen]
    brightest = frames[:, ::2, ::2].max(axis=-1)
    white = float((brightest == WHITE_GREY).mean())
    black = float((brightest <= DARK_GREY).mean())
    middle = float(np.median(brightest))
    noise = noise_grey(frames[:, ::4, :, GREEN])
    return [
        judged(
            "brightness",
            f"the middle level is {middle:.0f} of 255.",
            "An imprint changes a dim picture by few grey levels, and noise hides it.",
            "Lengthen the camera's exposure, or turn the sensor's lights up.",
            is_fault=middle < 2 * DIM_GREY,
        ),
        judged(
            "clipping",
            f"{white:.1%} of the pixels are at the upper end of the scale, {black:.1%} black.",
            "Where a pixel is at its end nothing that touches changes it.",
            "Shorten the camera's exposure, or crop black borders away.",
            is_fault=max(white, black) > MOST_CLIPPED,
        ),
        judged(
            "noise",
            f"{noise:.1f} grey levels.",
            "Fine imprints drown in it; beyond 9 grey levels a clip is refused.",
            "Lower the camera's gain, or average several frames into each.",
            is_fault=noise > MOST_NOISE_GREY,
        ),
    ]
