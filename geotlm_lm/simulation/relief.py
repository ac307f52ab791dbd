"""Marks that a face may bear: spots and ticks around a circle, strokes, pictures; lengths in mm."""

from __future__ import annotations

import cv2
import numpy as np

from geotlm_lm.simulation.indenter import HeightMap, hypot
from geotlm_lm.simulation.raster import PX_PER_MM, RASTER_SIDE
from geotlm_lm.simulation.smooth_field import smooth_field

_SUBPIXEL_BITS = 4


def polar(x: HeightMap, y: HeightMap) -> tuple[HeightMap, HeightMap]:
    """Return the angle, -pi to pi from x towards y, and the distance from the origin."""
    return np.arctan2(y, x), hypot(x, y)


def to_nearest(angle: HeightMap, count: int | HeightMap) -> HeightMap:
    """Return the angle from the nearest of `count` even directions, the first along x."""
    step = np.float32(2 * np.pi) / count
    return angle - np.round(angle / step) * step


def within(distance_mm: HeightMap, radius_mm: float, ramp_mm: float) -> HeightMap:
    """Return 1 inside `radius_mm`, 0 outside, with a ramp between."""
    return np.clip((radius_mm - distance_mm) / np.float32(ramp_mm), 0, 1)


def strokes(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, count: int, reach_mm: float
) -> HeightMap:
    """Return 1 along a few random straight strokes, as of stamped letters, and 0 elsewhere."""
    drawn, px_per_mm = np.zeros(x.shape, np.uint8), 1 / float(x[0, 1] - x[0, 0])
    for _ in range(count):
        middle, angle = rng.uniform(-reach_mm, reach_mm, 2), rng.uniform(0, np.pi)
        half = rng.uniform(0.5, 2.0) * np.array([np.cos(angle), np.sin(angle)])
        ends = (np.stack([middle - half, middle + half]) - (x[0, 0], y[0, 0])) * px_per_mm
        first, last = np.round(ends * 2**_SUBPIXEL_BITS).astype(int).tolist()
        width = max(round(rng.uniform(0.5, 1.0) * px_per_mm), 1)
        cv2.line(drawn, first, last, 255, width, cv2.LINE_AA, _SUBPIXEL_BITS)
    return drawn.astype(np.float32) / 255


def picture(x: HeightMap, rng: np.random.Generator, *, scale_mm: float) -> HeightMap:
    """Return a smooth random relief of unit deviation, as of a worn portrait."""
    field = smooth_field(rng, RASTER_SIDE, scale_mm * PX_PER_MM)
    thinned = slice(None, None, RASTER_SIDE // len(x))
    return field[thinned, thinned]
