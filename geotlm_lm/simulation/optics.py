"""Height of the gel's surface to camera frames; knows no object and no print.

A frame is the idle frame B changed by three coloured lights (channel c),
I_c = B_c [1 + A_c . g / sqrt(1 + beta^2 |g|^2) + a_c d] with g = -grad d and d the indentation,
which fits a GelSight Mini better (R^2 0.88 / 0.85 / 0.74 in R, G, B) than additive shading.
"""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.scene import Optics

Planar = NDArray[np.float32]

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
    slope_x, slope_y, unlit = _slopes(height_mm, optics)
    around = None
    if optics.shadow > 0:  # the map goes on, level, as far beyond its border as shadows reach
        x, y = (round(SHADOW_REACH_MM / size) for size in (optics.mm_per_px_x, optics.mm_per_px_y))
        around = cv2.copyMakeBorder(height_mm, y, y, x, x, cv2.BORDER_REPLICATE)
    reach = _reach(optics.light_slope_x, optics.light_slope_y)
    frames, shade = np.empty_like(base), np.empty_like(height_mm)
    for channel, (light_x, light_y) in enumerate(lights.tolist()):
        cv2.addWeighted(slope_x, light_x, slope_y, light_y, 0, dst=shade)
        if around is not None:
            shadow = _shadow(height_mm, around, (light_x, light_y), optics)
            cv2.scaleAdd(shadow, -optics.shadow / SHADOW_REACH_MM, shade, dst=shade)
        shade *= reach[channel]
        cv2.scaleAdd(height_mm, optics.depth_gain[channel], shade, dst=shade)
        shade += unlit
        np.multiply(base[channel], cv2.max(shade, 0.05, dst=shade), out=frames[channel])
    return frames


def _slopes(height_mm: Planar, optics: Optics) -> tuple[Planar, Planar, Planar]:
    """Return the slopes towards right and down as they shade, and what steepness leaves of light.

    Flanks see less of the lit inside of the sensor: a loss common to all channels.
    """
    slope_x = cv2.Sobel(height_mm, cv2.CV_32F, 1, 0, ksize=3, scale=-0.125 / optics.mm_per_px_x)
    slope_y = cv2.Sobel(height_mm, cv2.CV_32F, 0, 1, ksize=3, scale=-0.125 / optics.mm_per_px_y)
    steep = cv2.accumulateProduct(slope_y, slope_y, cv2.multiply(slope_x, slope_x))
    if optics.saturation > 0:
        soft = cv2.addWeighted(steep, optics.saturation**2, steep, 0, 1)
        cv2.sqrt(soft, dst=soft)
        cv2.divide(slope_x, soft, dst=slope_x)
        cv2.divide(slope_y, soft, dst=slope_y)
    # 1 - loss * steep / (1 + steep), in two passes.
    loss = 2 * optics.steep_darkening
    steep += 1
    unlit = cv2.divide(loss, steep, dst=steep)
    unlit += np.float32(1 - loss)
    return slope_x, slope_y, unlit


@lru_cache(maxsize=2)
def _reach(slope_x: tuple[float, ...], slope_y: tuple[float, ...]) -> Planar:
    """Return each light's strength over the pad, (3, 224, 224).

    A light's own reach is not the idle frame's: it also falls on the markerless coat at another
    angle, so each shading may grow towards one side.
    """
    axis = np.linspace(-1, 1, IMAGE_SIDE, dtype=np.float32)
    across, down = (1 + np.float32(slopes)[:, None] * axis for slopes in (slope_x, slope_y))
    return across[:, None, :] * down[:, :, None]


def turned_lights(optics: Optics) -> NDArray[np.float64]:
    """Return the shading rows of the three lights, (3, 2), with this clip's turns and gains."""
    # The lights sit on the pad: they turn with it.
    angles = np.asarray(optics.light_turn_rad) + optics.mounting.turn_rad
    cos, sin = np.cos(angles), np.sin(angles)
    right, down = np.array(optics.lamps.rows).T
    x = cos * right - sin * down
    y = sin * right + cos * down
    rows = np.stack([x, y], axis=1) * np.asarray(optics.light_gain)[:, None]
    return rows + np.asarray(optics.common_light)


def _shadow(
    height_mm: Planar, around: Planar, light: tuple[float, float], optics: Optics
) -> Planar:
    """Return how much a flank towards the light overtops a pixel, in mm; `around` has margins."""
    length = math.hypot(*light) or 1.0  # light from all around casts its shadow nowhere
    column = round(SHADOW_REACH_MM * light[0] / length / optics.mm_per_px_x)
    row = round(SHADOW_REACH_MM * light[1] / length / optics.mm_per_px_y)
    height, width = height_mm.shape
    row, column = row + (len(around) - height) // 2, column + (around.shape[1] - width) // 2
    ahead = cv2.subtract(around[row : row + height, column : column + width], height_mm)
    return cv2.max(ahead, 0, dst=ahead)
