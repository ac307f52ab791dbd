"""What cameras and files take away from pictures: light, contrast, detail.

Knows pixels; neither what they show nor how much damage is usual.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames


def jpeg(quality: float, image: Frames) -> Frames:
    """Return an image through JPEG of a quality from 0 to 100."""
    packed = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, int(quality)])[1]
    return cv2.imdecode(packed, cv2.IMREAD_COLOR)[..., ::-1].copy()


def gained(gain: float, image: Frames) -> Frames:
    """Return an image exposed `gain` times as long."""
    return as_pixels(image * float(gain))


def drifted(offset_grey: float, gain: float, frames: Frames) -> Frames:
    """Return frames growing brighter, evenly from the first one to the last.

    Args:
        offset_grey: Added to the last frame, grey levels.
        gain: Share by which the last frame is brighter besides.
        frames: uint8 (t, rows, columns, 3).
    """
    share = np.linspace(0, 1, len(frames))[:, None, None, None]
    return as_pixels(frames * (1 + gain * share) + offset_grey * share)


def faded(contrast: float, frames: Frames, background: Frames) -> Frames:
    """Return frames with only a share of their change, noise and all, against the background."""
    idle = background.astype(np.float64)
    return as_pixels(idle + contrast * (frames - idle))


def as_pixels(values: NDArray[np.floating]) -> Frames:
    """Return values rounded and cut to what a pixel holds."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
