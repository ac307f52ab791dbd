"""Irregular surfaces for training: peels, foams, creases, gravel, fibres, bark; formulas only."""

from __future__ import annotations

from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.simulation.indenter import (
    HeightMap,
    Indenter,
    bowl,
    extended,
    rounded_back,
    turned,
)
from geotlm_lm.simulation.raster import PX_PER_MM, RASTER_MM, RASTER_SIDE
from geotlm_lm.simulation.smooth_field import smooth_field


def bumpy(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    scale_mm: float,
    rise_mm: float,
    octaves: int = 1,
    flattest_mm: float = 50.0,
) -> HeightMap:
    """Return a back with smooth random bumps, finer ones on top of coarse ones."""
    height = rounded_back(x, y, rng, flattest_mm)
    for octave in range(octaves):
        height = height + np.float32(rise_mm * 0.55**octave) * _field(rng, scale_mm * 0.5**octave)
    return height


def creased(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, scale_mm: float, rise_mm: float
) -> HeightMap:
    """Return crumpled sheet: sharp random folds, the higher the further apart."""
    height = rounded_back(x, y, rng, 60.0)
    for octave in range(2):
        fold = np.abs(_field(rng, scale_mm * 0.6**octave))
        height = height + np.float32(rise_mm * 0.5**octave) * np.sqrt(fold * fold + 0.01)
    return height


def pitted(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    scale_mm: float,
    depth_mm: float,
    share: float,
) -> HeightMap:
    """Return a surface with random hollows over `share` of it: foam, sponge, bread."""
    field = _field(rng, scale_mm)
    level = np.quantile(field[::8, ::8], 1 - share)
    hollow = np.clip((field - level) * 1.5, 0, 1)
    return rounded_back(x, y, rng, 60.0) + np.float32(depth_mm) * np.sqrt(hollow)


def islands(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, scale_mm: float, share: float
) -> HeightMap:
    """Return separate random patches of material, and nothing much between them."""
    field = _field(rng, scale_mm)
    level = np.quantile(field[::8, ::8], 1 - share)
    return rounded_back(x, y, rng, 40.0) - 0.8 * np.sqrt(np.clip((field - level) * 0.8, 0, 1))


def gravel(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, spacing_mm: float, radius_mm: float
) -> HeightMap:
    """Return round grains at random places, each the Voronoi cell of its middle."""
    side = int(RASTER_MM / spacing_mm)
    lattice = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    points = (lattice + rng.uniform(0.1, 0.9, lattice.shape)) * spacing_mm * PX_PER_MM
    seeds = np.full((RASTER_SIDE, RASTER_SIDE), 255, np.uint8)
    inside = np.clip(points.astype(int), 0, RASTER_SIDE - 1)
    seeds[inside[:, 1], inside[:, 0]] = 0
    distance = _distance_mm(seeds)
    grain = np.minimum(distance**2 / np.float32(2 * radius_mm), 1.5)
    return grain + 0.05 * _field(rng, 2 * spacing_mm) + rounded_back(x, y, rng, 40.0)


def labyrinth(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, scale_mm: float, bands: float
) -> HeightMap:
    """Return winding ridges of even width: brain coral, fingerprints, wrinkled skin."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    phase = bands * _field(rng, scale_mm) + rng.uniform(0.0, 1.5) * u
    ridge = np.sin(2.0 * phase.astype(np.float32)) * np.float32(rng.uniform(0.05, 0.15))
    return ridge + rounded_back(u, v, rng, 40.0)


def grain(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, width_mm: float, rise_mm: float
) -> HeightMap:
    """Return random streaks in one direction: wood, brushed metal, bark."""
    across = smooth_field(rng, RASTER_SIDE, width_mm * PX_PER_MM)
    start = int(rng.integers(0, RASTER_SIDE * 3 // 4))
    strip = np.ascontiguousarray(across[:, start : start + RASTER_SIDE // 5])
    streaks = cv2.resize(strip, (RASTER_SIDE, RASTER_SIDE), interpolation=cv2.INTER_CUBIC)
    return np.float32(rise_mm) * streaks + rounded_back(x, y, rng, 50.0)


def fibres(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    count: int,
    radius_mm: float,
    curl: float,
) -> HeightMap:
    """Return wires lying at random on a back, straight or curled."""
    canvas = np.full((RASTER_SIDE, RASTER_SIDE), 255, np.uint8)
    for _ in range(count):
        turns = np.cumsum(rng.normal(0, curl, 24)) + rng.uniform(-np.pi, np.pi)
        steps = np.stack([np.cos(turns), np.sin(turns)], 1) * 0.6 * PX_PER_MM
        line = np.cumsum(steps, 0) + rng.uniform(0.1, 0.9, 2) * RASTER_SIDE
        cv2.polylines(canvas, [np.round(line * 16).astype(np.int32)], False, 0, 1, shift=4)
    distance = _distance_mm(canvas)
    distance = cv2.GaussianBlur(distance, (5, 5), 1.0)
    ratio = np.minimum(distance / radius_mm, 1.0)
    level = 0.3 * np.float32(radius_mm) * _field(rng, 3.0)
    back = rounded_back(x, y, rng, 40.0)
    return back + level - np.float32(2 * radius_mm) * np.sqrt(1 - ratio * ratio)


def lumpy_ball(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, radius_mm: float, rise_mm: float
) -> HeightMap:
    """Return a small irregular lump: a ball deformed by coarse noise (stones, nuts, knuckles)."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    body = bowl(u, v * np.float32(rng.uniform(0.8, 1.6)), radius_mm)
    return body + np.float32(rise_mm) * _field(rng, 2.5) + 0.3 * rise_mm * _field(rng, 0.9)


def _distance_mm(canvas: NDArray[np.uint8]) -> HeightMap:
    """Return the distance of every pixel from the nearest zero."""
    distance = cv2.distanceTransform(canvas, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # The last bit depends on how the array lies in memory; squared distances are whole numbers.
    return np.sqrt(np.rint(np.square(distance))) / np.float32(PX_PER_MM)


def _field(rng: np.random.Generator, scale_mm: float) -> NDArray[np.float32]:
    return smooth_field(rng, RASTER_SIDE, scale_mm * PX_PER_MM)


ROUGH: dict[str, Indenter] = {
    "peel_fine": extended(partial(bumpy, scale_mm=0.8, rise_mm=0.03)),
    "peel_coarse": extended(partial(bumpy, scale_mm=1.6, rise_mm=0.08)),
    "warts": extended(partial(bumpy, scale_mm=1.2, rise_mm=0.18)),
    "felt": extended(partial(bumpy, scale_mm=0.6, rise_mm=0.03, octaves=2, flattest_mm=80.0)),
    "sandpaper": extended(partial(bumpy, scale_mm=0.4, rise_mm=0.04, flattest_mm=80.0)),
    "rock": extended(partial(bumpy, scale_mm=3.0, rise_mm=0.25, octaves=4)),
    "plaster": extended(partial(bumpy, scale_mm=1.0, rise_mm=0.07, octaves=3)),
    "hills": extended(partial(bumpy, scale_mm=4.0, rise_mm=0.35, octaves=2)),
    "foil_crumpled": extended(partial(creased, scale_mm=2.5, rise_mm=0.25)),
    "paper_crumpled": extended(partial(creased, scale_mm=5.0, rise_mm=0.35)),
    "film_wrinkled": extended(partial(creased, scale_mm=1.3, rise_mm=0.10)),
    "foam_open": extended(partial(pitted, scale_mm=1.5, depth_mm=0.8, share=0.5)),
    "foam_fine": extended(partial(pitted, scale_mm=0.7, depth_mm=0.4, share=0.4)),
    "crumb": extended(partial(pitted, scale_mm=2.5, depth_mm=1.0, share=0.35)),
    "islands_small": extended(partial(islands, scale_mm=1.5, share=0.3)),
    "islands_large": extended(partial(islands, scale_mm=3.0, share=0.4)),
    "gravel_fine": extended(partial(gravel, spacing_mm=1.3, radius_mm=0.6)),
    "gravel_coarse": extended(partial(gravel, spacing_mm=2.6, radius_mm=1.5)),
    "beads_loose": extended(partial(gravel, spacing_mm=4.0, radius_mm=2.0)),
    "coral": extended(partial(labyrinth, scale_mm=3.0, bands=3.0)),
    "skin_folded": extended(partial(labyrinth, scale_mm=6.0, bands=5.0)),
    "grain_fine": extended(partial(grain, width_mm=0.8, rise_mm=0.06)),
    "bark": extended(partial(grain, width_mm=2.0, rise_mm=0.22)),
    "wires_straight": extended(partial(fibres, count=25, radius_mm=0.5, curl=0.05)),
    "wool_curled": extended(partial(fibres, count=40, radius_mm=0.3, curl=0.5)),
    "straw": extended(partial(fibres, count=14, radius_mm=0.8, curl=0.02)),
    "lump_small": extended(partial(lumpy_ball, radius_mm=3.0, rise_mm=0.10)),
    "lump_large": extended(partial(lumpy_ball, radius_mm=9.0, rise_mm=0.20)),
}
"""Irregular surfaces by name."""
