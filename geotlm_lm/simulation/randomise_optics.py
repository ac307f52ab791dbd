"""Random cameras, lights and recordings, from ranges measured on real units; knows no object."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geotlm_lm.core.numbers import log_uniform
from geotlm_lm.simulation.scene import Markers, Mounting, Optics, VideoCodec

ZOOM = (0.6, 1.15)
"""Pixel size relative to a GelSight Mini's 20.3 x 15.2 mm view; small views see single details."""

ASPECT = (0.95, 1.08)
"""Pixel width over height, relative to square ones (two cameras measured)."""

MOUNTING_TURN_DEG = 3.0
"""Largest turn of the camera about its axis."""

MOUNTING_SHIFT_MM = 0.85
"""Farthest the pad's middle lies off the view's: half of what the view of 20.3 mm that readers crop
exceeds the 18.6 mm of the data sheet."""

LIGHT_TURN_DEG = 15.0
"""Farthest a light's direction lies from its usual one."""

USUAL_TURN_DEG = (0.0, -4.0, -7.0)
"""Usual direction of each light (R, G, B) relative to the unit whose slopes were measured: three
real sources are lit from -97, 7 and 81 degrees, it from -96, 8 and 93."""

STRENGTH = (0.4, 2.1)
"""Shading relative to the measured unit, drawn evenly on a log scale; real units go up to 2.3."""

CHANNEL_STRENGTH = ((0.65, 1.3), (0.8, 1.9), (0.65, 1.35))
"""Further factor per light, R, G, B; a second unit's is 2.3, 3.1 and 2.1 times the first's."""

LIGHT_SLOPE = 0.35
"""Largest relative growth of a light's shading from the middle to a border."""

COMMON_LIGHT = 0.14
"""Spread of what all channels change by per unit slope, relative to `STRENGTH`: it takes the
channels' correlation on contacts from below -0.9 to the real -0.8."""

STEEP_DARKENING = (0.0, 0.22)
"""Darkening at slope 1, relative to `STRENGTH`: real imprints are as bright as the idle gel on the
whole (0.3, -0.9 and -0.4 %)."""

SATURATION = (0.0, 2.0)
"""Softness of steep slopes; 1 to 2 fit one ball press."""

DEPTH_GAIN_PER_MM = (0.066, 0.037, 0.083)
"""Relative brightening per mm of indentation, R, G, B, measured on one unit."""

DEPTH_SHARE = ((0.4, 2.2), (0.4, 2.2), (0.0, 1.6))
"""Factor on that, R, G, B."""

SHADOW = (-0.3, 0.3)
"""Shadow behind flanks per unit slope, none below 0."""

PSF_MM = (0.0, 0.07)
"""Blur of the camera; real images hold signal up to 0.35 cycles per pixel."""

NOISE_GREY = (1.7, 1.24, 2.0)
"""Standard deviation of one frame's noise, R, G, B, measured on an uncompressed camera."""

NOISE_SHARE = (0.15, 1.8)
"""Factor on that, drawn evenly on a log scale: down to a recording that was averaged or scaled."""

DRIFT_GREY = (0.02, 0.6)
"""Spread of the white balance between frames, drawn evenly on a log scale; 0.07 to 0.11 in videos,
up to 1 grey level where a camera sets it by itself."""

SESSION_SHARE = 0.3
"""Share of clips whose idle frame was taken in another session."""

SESSION_CHANGE = 0.02
"""Spread of the light from one session to another, relative."""

VIDEO_SHARE = 0.5
"""Share of clips that come out of a lossy video, as all 237 real recordings at hand do."""

VIDEO_STRENGTH = (0.75, 1.5)
"""Its noise relative to the measured videos', drawn evenly on a log scale."""

VIDEO_FRAMES_APART = 12
"""Most frames of a video between two of a clip; drawn evenly on a log scale from 1."""

JPEG_SHARE = 0.12
"""Share of clips stored as single JPEG images."""

JPEG_QUALITY = (60, 96)

MARKER_SPACING_MM = (1.8, 2.9)
MARKER_DIAMETER_SHARE = (0.3, 0.45)
MARKER_DARKNESS = (0.45, 0.8)
"""Dots: distance, width relative to it, darkness; about five recordings of marked GelSight Minis
(1.9 to 2.8 mm, 0.36 to 0.43, 0.56 to 0.62)."""


def random_optics(rng: np.random.Generator) -> Optics:
    """Return a camera, lights and noise within the ranges real units were measured in."""
    zoom, ratio = rng.uniform(*ZOOM), rng.uniform(*ASPECT)
    strength = log_uniform(rng, STRENGTH)
    turns = np.radians(USUAL_TURN_DEG + rng.uniform(-1, 1, 3) * LIGHT_TURN_DEG)
    is_other_session = rng.random() < SESSION_SHARE
    how = rng.random()
    return Optics(
        mm_per_px_x=20.3 / 224 * zoom * ratio**0.5,
        mm_per_px_y=15.2 / 224 * zoom / ratio**0.5,
        light_turn_rad=_three(turns),
        light_gain=_three([strength * rng.uniform(*span) for span in CHANNEL_STRENGTH]),
        light_slope_x=_three(rng.uniform(-LIGHT_SLOPE, LIGHT_SLOPE, 3)),
        light_slope_y=_three(rng.uniform(-LIGHT_SLOPE, LIGHT_SLOPE, 3)),
        common_light=tuple(strength * rng.normal(0, COMMON_LIGHT) for _ in range(2)),
        steep_darkening=strength * rng.uniform(*STEEP_DARKENING),
        saturation=rng.uniform(*SATURATION),
        depth_gain=_three(
            [gain * rng.uniform(*s) for gain, s in zip(DEPTH_GAIN_PER_MM, DEPTH_SHARE, strict=True)]
        ),
        shadow=max(rng.uniform(*SHADOW), 0.0),
        psf_mm=rng.uniform(*PSF_MM),
        noise_grey=_three(np.array(NOISE_GREY) * log_uniform(rng, NOISE_SHARE)),
        drift_grey=log_uniform(rng, DRIFT_GREY),
        light_change=_three(rng.normal(0, SESSION_CHANGE, 3) * is_other_session),
        jpeg_quality=int(rng.integers(*JPEG_QUALITY)) if how > 1 - JPEG_SHARE else None,
        video=_random_video(rng) if how < VIDEO_SHARE else None,
        idle=int(rng.integers(2**31)),
        mounting=_random_mounting(rng),
    )


def random_markers(rng: np.random.Generator) -> Markers:
    """Return a grid of dots like those of gels on sale."""
    spacing = rng.uniform(*MARKER_SPACING_MM)
    return Markers(
        spacing_mm=spacing,
        diameter_mm=spacing * rng.uniform(*MARKER_DIAMETER_SHARE),
        darkness=rng.uniform(*MARKER_DARKNESS),
        x_mm=rng.uniform(-0.5, 0.5) * spacing,
        y_mm=rng.uniform(-0.5, 0.5) * spacing,
    )


def _random_mounting(rng: np.random.Generator) -> Mounting:
    turn, x, y = rng.uniform(-1, 1, 3)
    return Mounting(
        turn_rad=float(np.radians(turn * MOUNTING_TURN_DEG)),
        x_mm=float(x * MOUNTING_SHIFT_MM),
        y_mm=float(y * MOUNTING_SHIFT_MM),
    )


def _random_video(rng: np.random.Generator) -> VideoCodec:
    strength, usual = log_uniform(rng, VIDEO_STRENGTH), VideoCodec()
    return VideoCodec(
        whole_grey=_three(strength * np.array(usual.whole_grey)),
        predicted_grey=_three(strength * np.array(usual.predicted_grey)),
        frames_apart=round(log_uniform(rng, (1, VIDEO_FRAMES_APART))),
    )


def _three(values: Sequence[float] | np.ndarray) -> tuple[float, float, float]:
    first, second, third = (float(value) for value in values)
    return first, second, third
