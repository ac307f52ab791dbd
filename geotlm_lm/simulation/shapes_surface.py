"""Surfaces for training: peels, foams, creases, gravel, fibres, weaves, knits, ropes, threads."""

from __future__ import annotations

from functools import partial

import cv2
import numpy as np

from geotlm_lm.simulation.shapes import (
    PX_PER_MM,
    RASTER_MM,
    RASTER_SIDE,
    Indenter,
    bowl,
    hypot,
    rounded_back,
    smooth_field,
    turned,
)


def bumpy(
    x, y, rng, *, scale_mm: float, rise_mm: float, octaves: int = 1, flattest_mm: float = 50.0
):
    """Return a back with smooth random bumps, finer ones on top of coarse ones."""
    height = rounded_back(x, y, rng, flattest_mm)
    for octave in range(octaves):
        height = height + np.float32(rise_mm * 0.55**octave) * smooth_field(
            rng, scale_mm * 0.5**octave
        )
    return height


def creased(x, y, rng, *, scale_mm: float, rise_mm: float):
    """Return crumpled sheet: sharp random folds, the higher the further apart."""
    height = rounded_back(x, y, rng, 60.0)
    for octave in range(2):
        fold = np.abs(smooth_field(rng, scale_mm * 0.6**octave))
        height = height + np.float32(rise_mm * 0.5**octave) * np.sqrt(fold * fold + 0.01)
    return height


def pitted(x, y, rng, *, scale_mm: float, depth_mm: float, share: float):
    """Return a surface with random hollows over `share` of it: foam, sponge, bread."""
    field = smooth_field(rng, scale_mm)
    level = np.quantile(field[::8, ::8], 1 - share)
    hollow = np.clip((field - level) * 1.5, 0, 1)
    return rounded_back(x, y, rng, 60.0) + np.float32(depth_mm) * np.sqrt(hollow)


def islands(x, y, rng, *, scale_mm: float, share: float):
    """Return separate random patches of material, and nothing much between them."""
    field = smooth_field(rng, scale_mm)
    level = np.quantile(field[::8, ::8], 1 - share)
    return rounded_back(x, y, rng, 40.0) - 0.8 * np.sqrt(np.clip((field - level) * 0.8, 0, 1))


def gravel(x, y, rng, *, spacing_mm: float, radius_mm: float):
    """Return round grains at random places, each the Voronoi cell of its middle."""
    side = int(RASTER_MM / spacing_mm)
    lattice = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    points = (lattice + rng.uniform(0.1, 0.9, lattice.shape)) * spacing_mm * PX_PER_MM
    seeds = np.full((RASTER_SIDE, RASTER_SIDE), 255, np.uint8)
    inside = np.clip(points.astype(int), 0, RASTER_SIDE - 1)
    seeds[inside[:, 1], inside[:, 0]] = 0
    distance = _distance_mm(seeds)
    grain = np.minimum(distance**2 / np.float32(2 * radius_mm), 1.5)
    return grain + 0.05 * smooth_field(rng, 2 * spacing_mm) + rounded_back(x, y, rng, 40.0)


def labyrinth(x, y, rng, *, scale_mm: float, bands: float):
    """Return winding ridges of even width: brain coral, fingerprints, wrinkled skin."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    phase = bands * smooth_field(rng, scale_mm) + rng.uniform(0.0, 1.5) * u
    ridge = np.sin(2.0 * phase.astype(np.float32)) * np.float32(rng.uniform(0.05, 0.15))
    return ridge + rounded_back(u, v, rng, 40.0)


def grain(x, y, rng, *, width_mm: float, rise_mm: float):
    """Return random streaks in one direction: wood, brushed metal, bark."""
    across = smooth_field(rng, width_mm)
    start = int(rng.integers(0, RASTER_SIDE * 3 // 4))
    strip = np.ascontiguousarray(across[:, start : start + RASTER_SIDE // 5])
    streaks = cv2.resize(strip, (RASTER_SIDE, RASTER_SIDE), interpolation=cv2.INTER_CUBIC)
    return np.float32(rise_mm) * streaks + rounded_back(x, y, rng, 50.0)


def fibres(x, y, rng, *, count: int, radius_mm: float, curl: float):
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
    level = 0.3 * np.float32(radius_mm) * smooth_field(rng, 3.0)
    back = rounded_back(x, y, rng, 40.0)
    return back + level - np.float32(2 * radius_mm) * np.sqrt(1 - ratio * ratio)


def lumpy_ball(x, y, rng, *, radius_mm: float, rise_mm: float):
    """Return a small irregular lump: a ball deformed by coarse noise (stones, nuts, knuckles)."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    body = bowl(u, v * np.float32(rng.uniform(0.8, 1.6)), radius_mm)
    return (
        body + np.float32(rise_mm) * smooth_field(rng, 2.5) + 0.3 * rise_mm * smooth_field(rng, 0.9)
    )


def _distance_mm(canvas):
    """Return the distance of every pixel from the nearest zero."""
    distance = cv2.distanceTransform(canvas, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # The last bit depends on how the array lies in memory; squared distances are whole numbers.
    return np.sqrt(np.rint(np.square(distance))) / np.float32(PX_PER_MM)


def weave(x, y, rng, *, pitch_mm: float, shift: int, cover: float = 0.95, wobble: float = 0.15):
    """Return two families of threads passing over and under each other.

    A `shift` of 2 threads per repeat is a plain weave, 3 and 4 are twills; below a `cover` (thread
    width over pitch) of 1 the cloth has holes; without `wobble` it repeats exactly, as wire mesh.
    """
    back = rounded_back(x, y, rng, 60.0)
    u, v = _irregular(x, y, rng, wobble * pitch_mm, pitch_mm * rng.uniform(0.8, 1.25))
    warp = _threads(u, v, shift, cover)
    weft = _threads(v, u + 0.5, shift, cover)
    return back - np.float32(0.35 * pitch_mm) * np.maximum(warp, weft)


def knit(x, y, rng, *, pitch_mm: float):
    """Return columns of V-shaped loops."""
    back = rounded_back(x, y, rng, 50.0)
    u, v = _irregular(x, y, rng, 0.12 * pitch_mm, pitch_mm * rng.uniform(0.8, 1.25))
    column = np.abs(u % 1.0 - 0.5)
    loop = np.cos(2 * np.pi * (v + 1.2 * column)) * np.sin(2 * np.pi * column + 0.4)
    return back - np.float32(0.2 * pitch_mm) * loop.astype(np.float32)


def ribs(
    x, y, rng, *, pitch_mm: float, rise_mm: float, across_mm: float = 0.0, wobble: float = 0.1
):
    """Return rounded ribs, crossed by a second family when `across_mm` > 0."""
    back = rounded_back(x, y, rng, 50.0)
    u, v = _irregular(x, y, rng, wobble * pitch_mm, pitch_mm * rng.uniform(0.8, 1.25))
    height = np.abs(np.sin(np.pi * v))
    if across_mm > 0:
        height = np.maximum(height, np.abs(np.sin(np.pi * u * pitch_mm / across_mm)))
    return back - np.float32(rise_mm) * height


def quilted(x, y, rng, *, pitch_mm: float, rise_mm: float):
    """Return pillows in a square or rhombic lattice."""
    back = rounded_back(x, y, rng, 50.0)
    u, v = _irregular(x, y, rng, 0.05 * pitch_mm, pitch_mm)
    u = u + rng.uniform(-0.5, 0.5) * v
    pillow = np.abs(np.sin(np.pi * u) * np.sin(np.pi * v))
    return back - np.float32(rise_mm) * np.sqrt(pillow)


def rope(x, y, rng, *, radius_mm: float, strands: int, lay_mm: float):
    """Return a twisted rope: strands winding about a lying rod, either way."""
    radius = radius_mm * rng.uniform(0.8, 1.2)
    around = np.arcsin(np.clip(y / radius, -0.98, 0.98))
    handed = int(rng.choice([-1, 1]))
    phase = strands * around + handed * 2 * np.pi * x / lay_mm + rng.uniform(0, 6.28)
    bulge = np.abs(np.cos(phase / 2)) * 0.18 * radius
    bend = rng.uniform(0.0, 0.02) * x * x
    return _lying_rod(y, radius) + bend - bulge.astype(np.float32)


def thread(x, y, rng, *, radius_mm: float, pitch_mm: float, depth_mm: float):
    """Return a threaded rod: a triangular groove winding about it."""
    around = np.arcsin(np.clip(y / radius_mm, -0.98, 0.98))
    turns = x / pitch_mm + int(rng.choice([-1, 1])) * around / (2 * np.pi) + rng.uniform()
    groove = np.abs(turns % 1.0 - 0.5) * 2
    return _lying_rod(y, radius_mm) + np.float32(depth_mm) * groove.astype(np.float32)


def bundle(x, y, rng, *, radius_mm: float, level_mm: float):
    """Return wires side by side at uneven heights, slightly bent."""
    bend = y + rng.uniform(-0.02, 0.02) * x * x
    levels = rng.uniform(0, level_mm, 256).astype(np.float32)
    off = (bend / (2 * radius_mm) + 0.5) % 1.0 * 2 - 1
    wire = np.float32(radius_mm) * (1 - np.sqrt(np.maximum(1 - off * off, 0)))
    index = np.floor(bend / (2 * radius_mm) + 0.5)
    sag = rng.uniform(0.002, 0.03) * y * y
    return wire + levels[index.astype(int) % 256] + sag + rng.uniform(0.001, 0.01) * x * x


def seam(x, y, rng, *, stitch_mm: float, rise_mm: float):
    """Return a rounded body with a line of slanted stitches along a groove."""
    curve = y - rng.uniform(-0.06, 0.06) * x * x
    side = np.abs(curve)
    slant = (x / stitch_mm + 0.5 * side / stitch_mm + rng.uniform()) % 1.0
    stitch = np.maximum(np.cos(2 * np.pi * slant), 0) * np.exp(-(((side - 0.7) / 0.5) ** 2))
    groove = np.exp(-((side / 0.2) ** 2))
    body = rounded_back(x, y, rng, 40.0)
    return body + (0.6 * rise_mm * groove - rise_mm * stitch).astype(np.float32)


def links(x, y, rng, *, pitch_mm: float, radius_mm: float):
    """Return a chain or braid: overlapping oval rings along a line."""
    along = (x / pitch_mm + rng.uniform()) % 1.0 - 0.5
    oval = hypot(along * pitch_mm, 1.2 * y) - 0.42 * pitch_mm
    square = radius_mm**2 - oval**2
    ring = radius_mm - np.sqrt(np.maximum(square, 0))
    wall = 6.0 * np.maximum(np.abs(oval) - 0.95 * radius_mm, 0)
    return (ring + wall + rng.uniform(0.003, 0.03) * x * x).astype(np.float32)


def _lying_rod(y, radius_mm: float):
    inside = np.maximum(1 - (y / radius_mm) ** 2, 0)
    steep = 20 * np.maximum(np.abs(y) - 0.95 * radius_mm, 0)
    return (radius_mm * (1 - np.sqrt(inside)) + steep).astype(np.float32)


def _threads(u, v, shift: int, cover: float):
    """Return the height of threads along u, one per unit of v, in units of their thickness."""
    row = np.floor(v)
    off = ((v - row) * 2 - 1) / cover
    wave = np.cos(2 * np.pi * (u - row) / shift)
    return 0.5 * wave + np.sqrt(np.maximum(1 - off * off, 0)) - np.float32(0.5) * (np.abs(off) > 1)


def _irregular(x, y, rng, shift_mm: float, pitch_mm: float):
    """Return lattice coordinates, turned at random and bent as cloth is."""
    u, v = turned(x, y, rng.uniform(-np.pi, np.pi))
    for coordinate in (u, v):
        coordinate += np.float32(shift_mm) * smooth_field(rng, 3.0)
        coordinate += np.float32(rng.uniform(0, pitch_mm))
    return u / np.float32(pitch_mm), v / np.float32(pitch_mm)


_FORMULAS = {
    "peel_fine": partial(bumpy, scale_mm=0.8, rise_mm=0.03),
    "peel_coarse": partial(bumpy, scale_mm=1.6, rise_mm=0.08),
    "warts": partial(bumpy, scale_mm=1.2, rise_mm=0.18),
    "felt": partial(bumpy, scale_mm=0.6, rise_mm=0.03, octaves=2, flattest_mm=80.0),
    "sandpaper": partial(bumpy, scale_mm=0.4, rise_mm=0.04, flattest_mm=80.0),
    "rock": partial(bumpy, scale_mm=3.0, rise_mm=0.25, octaves=4),
    "plaster": partial(bumpy, scale_mm=1.0, rise_mm=0.07, octaves=3),
    "hills": partial(bumpy, scale_mm=4.0, rise_mm=0.35, octaves=2),
    "foil_crumpled": partial(creased, scale_mm=2.5, rise_mm=0.25),
    "paper_crumpled": partial(creased, scale_mm=5.0, rise_mm=0.35),
    "film_wrinkled": partial(creased, scale_mm=1.3, rise_mm=0.10),
    "foam_open": partial(pitted, scale_mm=1.5, depth_mm=0.8, share=0.5),
    "foam_fine": partial(pitted, scale_mm=0.7, depth_mm=0.4, share=0.4),
    "crumb": partial(pitted, scale_mm=2.5, depth_mm=1.0, share=0.35),
    "islands_small": partial(islands, scale_mm=1.5, share=0.3),
    "islands_large": partial(islands, scale_mm=3.0, share=0.4),
    "gravel_fine": partial(gravel, spacing_mm=1.3, radius_mm=0.6),
    "gravel_coarse": partial(gravel, spacing_mm=2.6, radius_mm=1.5),
    "beads_loose": partial(gravel, spacing_mm=4.0, radius_mm=2.0),
    "coral": partial(labyrinth, scale_mm=3.0, bands=3.0),
    "skin_folded": partial(labyrinth, scale_mm=6.0, bands=5.0),
    "grain_fine": partial(grain, width_mm=0.8, rise_mm=0.06),
    "bark": partial(grain, width_mm=2.0, rise_mm=0.22),
    "wires_straight": partial(fibres, count=25, radius_mm=0.5, curl=0.05),
    "wool_curled": partial(fibres, count=40, radius_mm=0.3, curl=0.5),
    "straw": partial(fibres, count=14, radius_mm=0.8, curl=0.02),
    "lump_small": partial(lumpy_ball, radius_mm=3.0, rise_mm=0.10),
    "lump_large": partial(lumpy_ball, radius_mm=9.0, rise_mm=0.20),
    "cloth_plain": partial(weave, pitch_mm=0.8, shift=2),
    "cloth_coarse": partial(weave, pitch_mm=1.5, shift=2),
    "twill_3": partial(weave, pitch_mm=0.8, shift=3),
    "twill_4": partial(weave, pitch_mm=1.0, shift=4),
    "gauze": partial(weave, pitch_mm=1.4, shift=2, cover=0.5),
    "basket": partial(weave, pitch_mm=2.4, shift=2),
    "mesh_fine": partial(weave, pitch_mm=0.9, shift=2, cover=0.4, wobble=0.0),
    "mesh_coarse": partial(weave, pitch_mm=1.8, shift=2, cover=0.35, wobble=0.0),
    "knit_fine": partial(knit, pitch_mm=1.2),
    "knit_coarse": partial(knit, pitch_mm=2.2),
    "corduroy": partial(ribs, pitch_mm=1.2, rise_mm=0.2),
    "corrugated": partial(ribs, pitch_mm=3.0, rise_mm=0.5, wobble=0.0),
    "waffle": partial(ribs, pitch_mm=2.5, rise_mm=0.4, across_mm=2.5),
    "knurl": partial(ribs, pitch_mm=1.3, rise_mm=0.3, across_mm=1.3, wobble=0.0),
    "net": partial(ribs, pitch_mm=3.2, rise_mm=0.7, across_mm=2.4),
    "quilt": partial(quilted, pitch_mm=4.0, rise_mm=0.4),
    "pillows": partial(quilted, pitch_mm=2.0, rise_mm=0.3),
    "rope_3": partial(rope, radius_mm=2.5, strands=3, lay_mm=7.0),
    "rope_6": partial(rope, radius_mm=3.5, strands=6, lay_mm=10.0),
    "thread_fine": partial(thread, radius_mm=3.0, pitch_mm=0.9, depth_mm=0.4),
    "thread_coarse": partial(thread, radius_mm=5.0, pitch_mm=2.0, depth_mm=0.8),
    "wires_parallel": partial(bundle, radius_mm=0.7, level_mm=0.3),
    "wires_thick": partial(bundle, radius_mm=1.5, level_mm=0.4),
    "seam_stitched": partial(seam, stitch_mm=1.8, rise_mm=0.35),
    "seam_fine": partial(seam, stitch_mm=1.1, rise_mm=0.2),
    "chain": partial(links, pitch_mm=4.0, radius_mm=0.8),
    "braid": partial(links, pitch_mm=2.2, radius_mm=0.5),
}

SURFACES: dict[str, Indenter] = {
    name: Indenter(formula, is_extended=True) for name, formula in _FORMULAS.items()
}
"""Irregular and repeating surfaces by name."""
