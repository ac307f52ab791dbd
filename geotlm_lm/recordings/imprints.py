"""What of a frame is an imprint: its change against the gel, between noise and slow shading."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.recordings.idle import activity_grey

NOISE_SIGMA, IMPRINT_SIGMA, SHADING_SIGMA = 1.0, 8.0, 12.0
"""Pixels of the activity image (80 columns): finer is noise, coarser than 8 is a change of light,
and an imprint is finer than 12."""

FAINT_IMPRINT = 0.75
"""Grey levels (rms) by which a touch changes the image, against a known background. Measured on
real recordings: 90 % of untouched frames are below 0.66, 95 % of those in contact above 0.8."""


def imprint_strength(clip: Clip) -> NDArray[np.float32]:
    """Return how strongly each frame is imprinted, in grey levels (rms), shape (t,)."""
    return strength_of(imprints_of(activity_grey(clip.frames), clip.background))


def touched_part(clip: Clip) -> Clip:
    """Return a recording from the first frame to the last that something touches; else all of it.

    Args:
        clip: Beside its idle gel.
    """
    places = np.flatnonzero(imprint_strength(clip) >= FAINT_IMPRINT)
    if len(places) < 2:
        return clip
    return clip.select(list(range(int(places[0]), int(places[-1]) + 1)))


def imprints_of(grey: NDArray[np.float32], background: Frames | None) -> NDArray[np.float32]:
    """Return each frame's grey change against the gel, smoothed and free of slow shading.

    Args:
        grey: `activity_grey` of the frames.
        background: The gel, in colour; None guesses it.
    """
    if background is not None:
        gel = activity_grey(background[None])[0]
    else:
        gel = cv2.GaussianBlur(np.median(grey, axis=0), (0, 0), SHADING_SIGMA)
    return np.stack([band_pass(image - gel) for image in grey])


def band_pass(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return an activity image without noise and without slow shading: what an imprint adds."""
    smooth = cv2.GaussianBlur(image, (0, 0), NOISE_SIGMA)
    return smooth - cv2.GaussianBlur(smooth, (0, 0), IMPRINT_SIGMA)


def strength_of(imprints: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return how strong each imprint is, in grey levels (rms), shape (t,)."""
    return np.sqrt(np.square(imprints).mean(axis=(1, 2)))
