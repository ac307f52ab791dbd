"""Repeating surfaces for training: weaves, knits, ribs, ropes, threads, seams; formulas only."""

from __future__ import annotations

from functools import partial

import numpy as np

from geotlm_lm.simulation.indenter import HeightMap, Indenter, extended, hypot, rounded_back, turned
from geotlm_lm.simulation.raster import PX_PER_MM, RASTER_SIDE
from geotlm_lm.simulation.smooth_field import smooth_field


def weave(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    pitch_mm: float,
    shift: int,
    cover: float = 0.95,
    wobble: float = 0.15,
) -> HeightMap:
    """Return two families of threads passing over and under each other.

    Args:
        x: Coordinates.
        y: Coordinates.
        rng: Draws pitch, phase and irregularity.
        pitch_mm: Distance of neighbouring threads.
        shift: Threads per repeat: 2 is a plain weave, 3 and 4 are twills.
        cover: Thread width over pitch; below 1 the cloth has holes.
        wobble: How far threads stray, relative to the pitch; 0 repeats exactly, as wire mesh does.
    """
    back = rounded_back(x, y, rng, 60.0)
    u, v = _irregular(x, y, rng, wobble * pitch_mm, pitch_mm * rng.uniform(0.8, 1.25))
    warp = _threads(u, v, shift, cover)
    weft = _threads(v, u + 0.5, shift, cover)
    return back - np.float32(0.35 * pitch_mm) * np.maximum(warp, weft)


def knit(x: HeightMap, y: HeightMap, rng: np.random.Generator, *, pitch_mm: float) -> HeightMap:
    """Return columns of V-shaped loops."""
    back = rounded_back(x, y, rng, 50.0)
    u, v = _irregular(x, y, rng, 0.12 * pitch_mm, pitch_mm * rng.uniform(0.8, 1.25))
    column = np.abs(u % 1.0 - 0.5)
    loop = np.cos(2 * np.pi * (v + 1.2 * column)) * np.sin(2 * np.pi * column + 0.4)
    return back - np.float32(0.2 * pitch_mm) * loop.astype(np.float32)


def ribs(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    pitch_mm: float,
    rise_mm: float,
    across_mm: float = 0.0,
    wobble: float = 0.1,
) -> HeightMap:
    """Return rounded ribs, crossed by a second family when `across_mm` > 0."""
    back = rounded_back(x, y, rng, 50.0)
    u, v = _irregular(x, y, rng, wobble * pitch_mm, pitch_mm * rng.uniform(0.8, 1.25))
    height = np.abs(np.sin(np.pi * v))
    if across_mm > 0:
        height = np.maximum(height, np.abs(np.sin(np.pi * u * pitch_mm / across_mm)))
    return back - np.float32(rise_mm) * height


def quilted(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, pitch_mm: float, rise_mm: float
) -> HeightMap:
    """Return pillows in a square or rhombic lattice."""
    back = rounded_back(x, y, rng, 50.0)
    u, v = _irregular(x, y, rng, 0.05 * pitch_mm, pitch_mm)
    u = u + rng.uniform(-0.5, 0.5) * v
    pillow = np.abs(np.sin(np.pi * u) * np.sin(np.pi * v))
    return back - np.float32(rise_mm) * np.sqrt(pillow)


def rope(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    radius_mm: float,
    strands: int,
    lay_mm: float,
) -> HeightMap:
    """Return a twisted rope: strands winding about a lying rod, either way."""
    radius = radius_mm * rng.uniform(0.8, 1.2)
    around = np.arcsin(np.clip(y / radius, -0.98, 0.98))
    handed = int(rng.choice([-1, 1]))
    phase = strands * around + handed * 2 * np.pi * x / lay_mm + rng.uniform(0, 6.28)
    bulge = np.abs(np.cos(phase / 2)) * 0.18 * radius
    bend = rng.uniform(0.0, 0.02) * x * x
    return _lying_rod(y, radius) + bend - bulge.astype(np.float32)


def thread(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    radius_mm: float,
    pitch_mm: float,
    depth_mm: float,
) -> HeightMap:
    """Return a threaded rod: a triangular groove winding about it."""
    around = np.arcsin(np.clip(y / radius_mm, -0.98, 0.98))
    turns = x / pitch_mm + int(rng.choice([-1, 1])) * around / (2 * np.pi) + rng.uniform()
    groove = np.abs(turns % 1.0 - 0.5) * 2
    return _lying_rod(y, radius_mm) + np.float32(depth_mm) * groove.astype(np.float32)


def bundle(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, radius_mm: float, level_mm: float
) -> HeightMap:
    """Return wires side by side at uneven heights, slightly bent."""
    bend = y + rng.uniform(-0.02, 0.02) * x * x
    levels = rng.uniform(0, level_mm, 256).astype(np.float32)
    off = (bend / (2 * radius_mm) + 0.5) % 1.0 * 2 - 1
    wire = np.float32(radius_mm) * (1 - np.sqrt(np.maximum(1 - off * off, 0)))
    index = np.floor(bend / (2 * radius_mm) + 0.5)
    sag = rng.uniform(0.002, 0.03) * y * y
    return wire + levels[index.astype(int) % 256] + sag + rng.uniform(0.001, 0.01) * x * x


def seam(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, stitch_mm: float, rise_mm: float
) -> HeightMap:
    """Return a rounded body with a line of slanted stitches along a groove."""
    curve = y - rng.uniform(-0.06, 0.06) * x * x
    side = np.abs(curve)
    slant = (x / stitch_mm + 0.5 * side / stitch_mm + rng.uniform()) % 1.0
    stitch = np.maximum(np.cos(2 * np.pi * slant), 0) * np.exp(-(((side - 0.7) / 0.5) ** 2))
    groove = np.exp(-((side / 0.2) ** 2))
    body = rounded_back(x, y, rng, 40.0)
    return body + (0.6 * rise_mm * groove - rise_mm * stitch).astype(np.float32)


def links(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, pitch_mm: float, radius_mm: float
) -> HeightMap:
    """Return a chain or braid: overlapping oval rings along a line."""
    along = (x / pitch_mm + rng.uniform()) % 1.0 - 0.5
    oval = hypot(along * pitch_mm, 1.2 * y) - 0.42 * pitch_mm
    square = radius_mm**2 - oval**2
    ring = radius_mm - np.sqrt(np.maximum(square, 0))
    wall = 6.0 * np.maximum(np.abs(oval) - 0.95 * radius_mm, 0)
    return (ring + wall + rng.uniform(0.003, 0.03) * x * x).astype(np.float32)


def _lying_rod(y: HeightMap, radius_mm: float) -> HeightMap:
    inside = np.maximum(1 - (y / radius_mm) ** 2, 0)
    steep = 20 * np.maximum(np.abs(y) - 0.95 * radius_mm, 0)
    return (radius_mm * (1 - np.sqrt(inside)) + steep).astype(np.float32)


def _threads(u: HeightMap, v: HeightMap, shift: int, cover: float) -> HeightMap:
    """Return the height of threads along u, one per unit of v, in units of their thickness."""
    row = np.floor(v)
    off = ((v - row) * 2 - 1) / cover
    wave = np.cos(2 * np.pi * (u - row) / shift)
    return 0.5 * wave + np.sqrt(np.maximum(1 - off * off, 0)) - np.float32(0.5) * (np.abs(off) > 1)


def _irregular(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, shift_mm: float, pitch_mm: float
) -> tuple[HeightMap, HeightMap]:
    """Return lattice coordinates, turned at random and bent as cloth is."""
    u, v = turned(x, y, rng.uniform(-np.pi, np.pi))
    for coordinate in (u, v):
        coordinate += np.float32(shift_mm) * smooth_field(rng, RASTER_SIDE, 3.0 * PX_PER_MM)
        coordinate += np.float32(rng.uniform(0, pitch_mm))
    return u / np.float32(pitch_mm), v / np.float32(pitch_mm)


WOVEN: dict[str, Indenter] = {
    "cloth_plain": extended(partial(weave, pitch_mm=0.8, shift=2)),
    "cloth_coarse": extended(partial(weave, pitch_mm=1.5, shift=2)),
    "twill_3": extended(partial(weave, pitch_mm=0.8, shift=3)),
    "twill_4": extended(partial(weave, pitch_mm=1.0, shift=4)),
    "gauze": extended(partial(weave, pitch_mm=1.4, shift=2, cover=0.5)),
    "basket": extended(partial(weave, pitch_mm=2.4, shift=2)),
    "mesh_fine": extended(partial(weave, pitch_mm=0.9, shift=2, cover=0.4, wobble=0.0)),
    "mesh_coarse": extended(partial(weave, pitch_mm=1.8, shift=2, cover=0.35, wobble=0.0)),
    "knit_fine": extended(partial(knit, pitch_mm=1.2)),
    "knit_coarse": extended(partial(knit, pitch_mm=2.2)),
    "corduroy": extended(partial(ribs, pitch_mm=1.2, rise_mm=0.2)),
    "corrugated": extended(partial(ribs, pitch_mm=3.0, rise_mm=0.5, wobble=0.0)),
    "waffle": extended(partial(ribs, pitch_mm=2.5, rise_mm=0.4, across_mm=2.5)),
    "knurl": extended(partial(ribs, pitch_mm=1.3, rise_mm=0.3, across_mm=1.3, wobble=0.0)),
    "net": extended(partial(ribs, pitch_mm=3.2, rise_mm=0.7, across_mm=2.4)),
    "quilt": extended(partial(quilted, pitch_mm=4.0, rise_mm=0.4)),
    "pillows": extended(partial(quilted, pitch_mm=2.0, rise_mm=0.3)),
    "rope_3": extended(partial(rope, radius_mm=2.5, strands=3, lay_mm=7.0)),
    "rope_6": extended(partial(rope, radius_mm=3.5, strands=6, lay_mm=10.0)),
    "thread_fine": extended(partial(thread, radius_mm=3.0, pitch_mm=0.9, depth_mm=0.4)),
    "thread_coarse": extended(partial(thread, radius_mm=5.0, pitch_mm=2.0, depth_mm=0.8)),
    "wires_parallel": extended(partial(bundle, radius_mm=0.7, level_mm=0.3)),
    "wires_thick": extended(partial(bundle, radius_mm=1.5, level_mm=0.4)),
    "seam_stitched": extended(partial(seam, stitch_mm=1.8, rise_mm=0.35)),
    "seam_fine": extended(partial(seam, stitch_mm=1.1, rise_mm=0.2)),
    "chain": extended(partial(links, pitch_mm=4.0, radius_mm=0.8)),
    "braid": extended(partial(links, pitch_mm=2.2, radius_mm=0.5)),
}
"""Repeating surfaces by name."""
