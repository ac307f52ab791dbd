"""Height of the gel's surface, and what is printed on it, to camera frames; knows no object.

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
from geotlm_lm.simulation.scene import Markers, Optics, Pattern

Planar = NDArray[np.float32]

SHADOW_REACH_MM = 0.6
"""How far from a flank its shadow is looked for; about the depth of a press."""

FLATNESS = 3.0
"""How flat a dot's middle is: its shade is 1 - exp(-FLATNESS g), g a Gaussian of height 1."""

_HALF_WIDTH = float(np.sqrt(-2 * np.log(np.log(2) / FLATNESS)))
"""Radius of half the darkness in standard deviations of that Gaussian."""

TILE_PX = 256
"""Side of the square that a pattern repeats; lines lie this far apart."""

BLOTCH_PX = 6.0
"""Correlation length of blotches on it: they repeat after 43 of these lengths."""

EDGE = 4.0
"""How sharp the edge of a blotch is, per standard deviation of the noise that is thresholded."""


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
    slope_x, slope_y = slopes_of(height_mm, optics.mm_per_px)
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


def slopes_of(height_mm: Planar, mm_per_px: tuple[float, float]) -> tuple[Planar, Planar]:
    """Return the slopes of an indentation that face right and down, mm per mm."""
    right, down = (-0.125 / size for size in mm_per_px)
    slope_x = cv2.Sobel(height_mm, cv2.CV_32F, 1, 0, ksize=3, scale=right)
    return slope_x, cv2.Sobel(height_mm, cv2.CV_32F, 0, 1, ksize=3, scale=down)


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


def print_shade(
    printed: Markers | Pattern, optics: Optics, drift_mm: Planar | None = None
) -> Planar:
    """Return the share of light that a print leaves, float32 (224, 224), 1 where there is none.

    What is printed on a point of the gel stands where that point has been carried, to any fraction
    of a pixel, by the gel's tangential displacement from rest, (2, 224, 224), x before y.
    """
    drift_mm = drift_mm if printed.is_carried else None
    if isinstance(printed, Pattern):
        return _pattern_shade(printed, optics, drift_mm)
    size = np.array([optics.mm_per_px_x, optics.mm_per_px_y])
    rest_px, ink = resting_dots(printed, optics)
    x, y = _moved(rest_px, size, drift_mm)
    sigma = printed.diameter_mm / 2 / _HALF_WIDTH / size
    pixels = np.arange(IMAGE_SIDE)
    across = np.exp(-0.5 * ((pixels - x[:, None]) / sigma[0]) ** 2).astype(np.float32)
    down = np.exp(-0.5 * ((pixels - y[:, None]) / sigma[1]) ** 2).astype(np.float32)
    if ink is not None:
        down *= ink[:, None]
    dots = 1 - np.exp(-FLATNESS * (down.T @ across))
    return (1 - np.float32(printed.darkness) * dots).astype(np.float32)


def resting_dots(
    markers: Markers, optics: Optics
) -> tuple[NDArray[np.float64], NDArray[np.float32] | None]:
    """Return where the dots of a gel at rest lie, (2, n) pixels, x before y, and their ink.

    The ink is a share of each dot's darkness, (n,), or None for all of it. The grid goes
    on one spacing beyond the view: what is carried into it is seen.
    """
    mounting, size = optics.mounting, np.array([[optics.mm_per_px_x], [optics.mm_per_px_y]])
    half_mm = IMAGE_SIDE / 2 * size
    reach = np.hypot(*half_mm[:, 0]) + np.hypot(mounting.x_mm, mounting.y_mm)
    count = int(np.ceil(reach / markers.spacing_mm)) + 1
    steps = np.arange(-count, count + 1) * markers.spacing_mm
    grid = np.stack([axis.ravel() for axis in np.meshgrid(steps, steps)])
    ink = None
    if markers.jitter or markers.missing or markers.unevenness:
        rng = np.random.default_rng(markers.seed)
        grid = grid + rng.uniform(-1, 1, grid.shape) * markers.jitter * markers.spacing_mm
        ink = 1 - markers.unevenness * rng.random(grid.shape[1], np.float32)
        ink *= rng.random(grid.shape[1]) >= markers.missing
    grid = grid + [[markers.x_mm], [markers.y_mm]]
    cos, sin = np.cos(mounting.turn_rad), np.sin(mounting.turn_rad)
    place = np.array([[cos, -sin], [sin, cos]]) @ grid + [[mounting.x_mm], [mounting.y_mm]]
    is_near = (np.abs(place) <= half_mm + markers.spacing_mm).all(axis=0)
    place = place[:, is_near]
    return place / size + (IMAGE_SIDE - 1) / 2, None if ink is None else ink[is_near]


def _moved(rest_px, size_mm, drift_mm: Planar | None) -> NDArray[np.float64]:
    if drift_mm is None:
        return rest_px
    inside = np.clip(rest_px, 0, IMAGE_SIDE - 1)
    column, row = np.minimum(inside.astype(int), IMAGE_SIDE - 2)
    right, low = inside[0] - column, inside[1] - row
    upper = (1 - right) * drift_mm[:, row, column] + right * drift_mm[:, row, column + 1]
    lower = (1 - right) * drift_mm[:, row + 1, column] + right * drift_mm[:, row + 1, column + 1]
    return rest_px + ((1 - low) * upper + low * lower) / size_mm[:, None]


def _pattern_shade(pattern: Pattern, optics: Optics, drift_mm: Planar | None) -> Planar:
    mounting, size = optics.mounting, (optics.mm_per_px_x, optics.mm_per_px_y)
    axis = np.arange(IMAGE_SIDE, dtype=np.float32)
    pixels = np.broadcast_to(axis, (IMAGE_SIDE, IMAGE_SIDE))
    column, row = pixels, pixels.T
    if drift_mm is not None:
        # The point X of the gel that is seen at x obeys X + u(X) = x; here X = x - u(x - u(x)).
        right, down = (plane / mm for plane, mm in zip(drift_mm, size, strict=True))
        at = (column - right, row - down)
        right, down = (
            cv2.remap(plane, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            for plane in (right, down)
        )
        column, row = column - right, row - down
    x, y = (
        (points - (IMAGE_SIDE - 1) / 2) * mm - shift
        for points, mm, shift in zip(
            (column, row), size, (mounting.x_mm, mounting.y_mm), strict=True
        )
    )
    cos, sin = np.cos(mounting.turn_rad), np.sin(mounting.turn_rad)
    along, across = cos * x + sin * y - pattern.x_mm, cos * y - sin * x - pattern.y_mm
    scale = TILE_PX if pattern.form == "mesh" else BLOTCH_PX
    on_tile = ((plane * scale / pattern.pitch_mm).astype(np.float32) for plane in (along, across))
    tile = _tile(pattern.form, pattern.share, pattern.seed)
    dark = cv2.remap(tile, *on_tile, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return 1 - np.float32(pattern.darkness) * dark


@lru_cache(maxsize=4)
def _tile(form: str, share: float, seed: int) -> Planar:
    """Return how dark one period of a pattern is, 0 to 1, (256, 256)."""
    if form == "mesh":
        place = (np.arange(TILE_PX) + 0.5) / TILE_PX - 0.5
        line = 1 / (1 + np.exp((np.abs(place) - share / 2) / (share / 8)))
        return np.maximum(line[:, None], line).astype(np.float32)
    waves = [np.fft.fftfreq(TILE_PX), np.fft.rfftfreq(TILE_PX)]
    square = waves[0][:, None] ** 2 + waves[1] ** 2
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((TILE_PX, TILE_PX)))
    field = np.fft.irfft2(noise * np.exp(-((np.pi * BLOTCH_PX) ** 2) * square))
    over = (field - np.quantile(field, 1 - share)) / field.std()
    return (1 / (1 + np.exp(-EDGE * over))).astype(np.float32)
