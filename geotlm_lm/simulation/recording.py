"""What a recording holds of a clip's frames: camera noise, drift and what storing them loses."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.simulation.noise import coded_noise, unit_noise
from geotlm_lm.simulation.scene import Optics

Planar = NDArray[np.float32]

BACKGROUND_NOISE = 0.45
"""Noise of an idle frame averaged over about five frames, relative to one frame's."""

WHOLE_EVERY = 12
"""Frames of a video from one stored whole to the next (measured on MPEG-4 recordings)."""

DRIFT_LIMIT_GREY = 1.0
"""Largest change of white balance between frames, per channel."""


class Recorder:
    """Records the frames of one clip in order; everything random comes from one generator."""

    def __init__(self, optics: Optics, rng: np.random.Generator) -> None:
        """Begin a recording with the noise and losses of `optics`, drawn from `rng`."""
        self.optics, self.rng = optics, rng
        self._still: Planar | None = None

    def background(self, idle: Planar) -> NDArray[np.uint8]:
        """Return the idle frame as recorded before the touch; averaging wears its noise down."""
        if self.optics.video is None:
            return recorded(idle, self.optics, self.rng, noise_share=BACKGROUND_NOISE)
        # Noise that stands still does not average out.
        return recorded(idle, self.optics, self.rng, still=coded_noise(self.rng))

    def next(self, frame: Planar) -> NDArray[np.uint8]:
        """Return the clip's next frame as recorded, uint8 (224, 224, 3)."""
        optics, rng = self.optics, self.rng
        drift = rng.normal(0, optics.drift_grey, 3).clip(-DRIFT_LIMIT_GREY, DRIFT_LIMIT_GREY)
        video = optics.video
        if video is not None:
            is_whole = rng.random() < video.frames_apart / WHOLE_EVERY
            if is_whole or self._still is None:
                self._still = coded_noise(rng)
        return recorded(frame, optics, rng, drift_grey=drift, still=self._still)


def recorded(
    frame: Planar,
    optics: Optics,
    rng: np.random.Generator,
    *,
    noise_share: float = 1.0,
    drift_grey: Sequence[float] = (0.0, 0.0, 0.0),
    still: Planar | None = None,
) -> NDArray[np.uint8]:
    """Return what the recording holds: noise added, 8 bit, perhaps lossy; (224, 224, 3) RGB.

    Args:
        frame: Planar frame without noise, (3, 224, 224).
        optics: Noise and compression.
        rng: Source of the noise.
        noise_share: Strength of the noise relative to one frame's.
        drift_grey: Brightness added to each channel.
        still: Noise of unit strength left by the last frame stored whole, (3, 224, 224); it goes
            with a video.
    """
    video = optics.video
    sigmas = optics.noise_grey if video is None else video.predicted_grey
    fresh = None if video is None else coded_noise(rng)
    planes = []
    for channel in range(3):
        noise, sign = (
            (unit_noise(rng), rng.random() < 0.5) if fresh is None else (fresh[channel], 1)
        )
        share, level = noise_share * sigmas[channel], float(drift_grey[channel])
        share = share if sign else -share
        plane = frame[channel]
        if video is not None and still is not None:
            plane = cv2.addWeighted(still[channel], video.whole_grey[channel], plane, 1.0, 0.0)
            # A block that changes too little is copied: whole grey levels are added to whole ones.
            np.rint(plane, out=plane)
        # One pass for sum, rounding and clipping: a third of the time of five.
        planes.append(cv2.addWeighted(noise, share, plane, 1.0, level, dtype=cv2.CV_8U))
    if optics.jpeg_quality is None:
        return cv2.merge(planes)
    bgr = cv2.merge(planes[::-1])
    code = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, optics.jpeg_quality])
    return cv2.imdecode(code[1], cv2.IMREAD_COLOR_RGB)
