"""Height of the gel's surface to camera frames; knows no object, no contact and no label.

A frame is the idle frame B changed by three coloured lights (channel c),
I_c = B_c [1 + A_c . g / sqrt(1 + beta^2 |g|^2) + a_c d] with g = -grad d and d the indentation,
which fits a GelSight Mini better (R^2 0.88 / 0.85 / 0.74 in R, G, B) than additive shading.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.noise import unit_noise
from geotlm_lm.simulation.scene import Optics

Planar = NDArray[np.float32]

LIGHTS = np.array([[-0.12, -1.08], [0.49, 0.07], [-0.03, 0.56]])
"""Relative change of R, G, B per unit slope g towards (right, down), measured on one unit."""

NOMINAL_VIEW_MM = 20.3
"""Width of the view the idle frame was measured on."""

SHADOW_REACH_MM = 0.6
"""How far from a flank its shadow is looked for; about the depth of a press."""


def lit(
    height_mm: Planar, base: Planar, optics: Optics, *, lights: NDArray[np.float64] | None = None
) -> Planar:
    """Return noise-free frames, planar (3, 224, 224), of one indentation map (224, 224) in mm."""
    lights = turned_lights(optics) if lights is None else lights
    blur_px = optics.psf_mm / min(optics.mm_per_px_x, optics.mm_per_px_y)
    if blur_px > 0.3:
        height_mm = cv2.GaussianBlur(height_mm, (5, 5), blur_px)
    slope_x = cv2.Sobel(height_mm, cv2.CV_32F, 1, 0, ksize=3, scale=-0.125 / optics.mm_per_px_x)
    slope_y = cv2.Sobel(height_mm, cv2.CV_32F, 0, 1, ksize=3, scale=-0.125 / optics.mm_per_px_y)
    steep = slope_x * slope_x
    steep += slope_y * slope_y
    if optics.saturation > 0:
        soft = np.sqrt(1 + np.float32(optics.saturation**2) * steep)
        slope_x /= soft
        slope_y /= soft
    # Flanks see less of the lit inside of the sensor: a loss common to all channels.
    common = np.float32(-2 * optics.steep_darkening) * (steep / (1 + steep))
    axis = np.linspace(-1, 1, IMAGE_SIDE, dtype=np.float32)
    frames = np.empty_like(base)
    for channel in range(3):
        light_x, light_y = lights[channel].astype(np.float32)
        shade = light_x * slope_x
        shade += light_y * slope_y
        if optics.shadow > 0:
            shade -= np.float32(optics.shadow) * _shadow(height_mm, lights[channel], optics)
        # A light's own reach over the pad is not the idle frame's: it also falls on the markerless
        # coat at another angle, so each shading may grow towards one side.
        shade *= 1 + np.float32(optics.light_slope_x[channel]) * axis[None, :]
        shade *= 1 + np.float32(optics.light_slope_y[channel]) * axis[:, None]
        shade += np.float32(optics.depth_gain[channel]) * height_mm
        shade += common
        shade += 1
        np.multiply(base[channel], np.maximum(shade, 0.05, out=shade), out=frames[channel])
    return frames


def turned_lights(optics: Optics) -> NDArray[np.float64]:
    """Return the shading rows of the three lights, (3, 2), with this clip's turns and gains."""
    angles = np.asarray(optics.light_turn_rad)
    cos, sin = np.cos(angles), np.sin(angles)
    x = cos * LIGHTS[:, 0] - sin * LIGHTS[:, 1]
    y = sin * LIGHTS[:, 0] + cos * LIGHTS[:, 1]
    rows = np.stack([x, y], axis=1) * np.asarray(optics.light_gain)[:, None]
    return rows + np.asarray(optics.common_light)


def recorded(
    frame: Planar, optics: Optics, rng: np.random.Generator, *, noise_share: float = 1.0
) -> NDArray[np.uint8]:
    """Return what the recording holds: noise added, 8 bit, perhaps lossy; (224, 224, 3) RGB."""
    planes = []
    for channel in range(3):
        noise = unit_noise(rng)
        sign = noise_share if rng.random() < 0.5 else -noise_share
        # 0.5 turns truncation into rounding.
        level = noise * np.float32(sign * optics.noise_grey[channel])
        level += frame[channel]
        level += 0.5
        planes.append(np.clip(level, 0, 255, out=level).astype(np.uint8))
    image = cv2.merge(planes)
    if optics.jpeg_quality is None:
        return image
    code = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, optics.jpeg_quality])
    return np.ascontiguousarray(cv2.imdecode(code[1], cv2.IMREAD_COLOR)[..., ::-1])


def _shadow(height_mm: Planar, light: NDArray[np.float64], optics: Optics) -> Planar:
    """Return how much a flank towards the light overtops each pixel, per mm of reach."""
    length = float(np.hypot(*light))
    step_x = SHADOW_REACH_MM * light[0] / length / optics.mm_per_px_x
    step_y = SHADOW_REACH_MM * light[1] / length / optics.mm_per_px_y
    matrix = np.array([[1, 0, round(step_x)], [0, 1, round(step_y)]], np.float32)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    side = (IMAGE_SIDE, IMAGE_SIDE)
    ahead = cv2.warpAffine(height_mm, matrix, side, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    ahead -= height_mm
    return np.maximum(ahead, 0, out=ahead) / np.float32(SHADOW_REACH_MM)
