"""Flat-faced bodies over an outline for training: prisms, rings, gears, strokes, gratings."""

from __future__ import annotations

from functools import partial

import numpy as np

from geotlm_lm.simulation.indenter import HeightMap, Indenter, bowl, extrude, hypot, turned


def prism(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    sides: int,
    apothem_mm: float,
    fillet_mm: float,
) -> HeightMap:
    """Return a regular prism standing on its end; `apothem_mm` is the inner radius."""
    return extrude(_polygon(x, y, sides, apothem_mm) + _crown(rng), fillet_mm)


def plate(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    half_mm: tuple[float, float],
    corner_mm: float,
    fillet_mm: float,
) -> HeightMap:
    """Return a rectangular plate with round corners."""
    half_x, half_y = (np.array(half_mm) * rng.uniform(0.8, 1.2, 2)).tolist()
    return extrude(_box(x, y, half_x, half_y, corner_mm), fillet_mm)


def disc_ring(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    inner_mm: float,
    outer_mm: float,
    gap_rad: float = 0.0,
) -> HeightMap:
    """Return a flat ring, with a gap when `gap_rad` > 0; oval by chance."""
    oval = rng.uniform(0.75, 1.0)
    radius = hypot(x, y / oval)
    inside = np.minimum(outer_mm - radius, radius - inner_mm)
    if gap_rad > 0:
        opening = (np.abs(np.arctan2(y, x)) - gap_rad / 2) * radius
        inside = np.minimum(inside, opening)
    return extrude(inside, 0.25)


def cross(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    arms: int,
    length_mm: float,
    width_mm: float,
) -> HeightMap:
    """Return bars from the middle outwards; unequal lengths by chance."""
    inside = np.full_like(x, -1e3)
    width = width_mm * rng.uniform(0.8, 1.3)
    for index in range(arms):
        u, v = turned(x, y, 2 * np.pi * index / arms)
        reach = length_mm * rng.uniform(0.7, 1.2)
        inside = np.maximum(inside, _segment(u, v, 0, 0, reach, 0, width / 2))
    return extrude(inside, min(0.25, 0.45 * width))


def gear(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    teeth: int,
    radius_mm: float,
    tooth_mm: float,
) -> HeightMap:
    """Return a wheel whose rim waves `teeth` times, sharper by chance."""
    angle, radius = np.arctan2(y, x), hypot(x, y)
    sharp = rng.uniform(1.0, 4.0)
    rim = radius_mm + tooth_mm * np.tanh(sharp * np.cos(teeth * angle)) / float(np.tanh(sharp))
    inside = (rim - radius) * 0.8
    if rng.random() < 0.4:
        inside = np.minimum(inside, radius - 0.4 * radius_mm)
    return extrude(inside, 0.2)


def strokes(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    points: tuple[tuple[float, float], ...],
    width_mm: float,
) -> HeightMap:
    """Return a raised letter: a pen drawn from point to point, in units of 3 mm."""
    inside = np.full_like(x, -1e3)
    slant = rng.uniform(-0.3, 0.3)
    reach = 3.0 * rng.uniform(0.8, 1.2)
    for (ax, ay), (bx, by) in zip(points[:-1], points[1:], strict=True):
        ends = ((ax + slant * ay) * reach, ay * reach, (bx + slant * by) * reach, by * reach)
        inside = np.maximum(inside, _segment(x, y, *ends, width_mm / 2))
    return extrude(inside, 0.3 * width_mm)


def scribble(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, corners: int, width_mm: float
) -> HeightMap:
    """Return a bent wire through random points."""
    points = tuple((float(a), float(b)) for a, b in rng.uniform(-1.4, 1.4, (corners, 2)))
    return strokes(x, y, rng, points=points, width_mm=width_mm)


def grating(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, pitch_mm: float, duty: float
) -> HeightMap:
    """Return parallel bars on a gently curved back."""
    pitch = pitch_mm * rng.uniform(0.8, 1.25)
    wave = np.abs((y / pitch + rng.uniform()) % 1.0 - 0.5) * pitch
    groove = np.clip((wave - duty * pitch / 2) * 2.0, 0, 0.5)
    return groove.astype(np.float32) + bowl(x, y, rng.uniform(20, 70))


def dots(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    pitch_mm: float,
    radius_mm: float,
    missing: float = 0.0,
) -> HeightMap:
    """Return a lattice of round studs on a curved back, some missing (as in raised print)."""
    lattice_x, lattice_y = x / pitch_mm, y / pitch_mm
    column, row = np.round(lattice_x), np.round(lattice_y)
    distance = hypot(lattice_x - column, lattice_y - row) * pitch_mm
    stud = np.clip(1 - (distance / radius_mm) ** 2, 0, None)
    if missing > 0:
        present = rng.random((64, 64)) >= missing
        stud = stud * present[row.astype(int) % 64, column.astype(int) % 64]
    rise = radius_mm * rng.uniform(0.5, 0.9)
    return (-rise * np.sqrt(stud)).astype(np.float32) + bowl(x, y, rng.uniform(15, 60))


def _polygon(x: HeightMap, y: HeightMap, sides: int, apothem_mm: float) -> HeightMap:
    angles = 2 * np.pi * np.arange(sides) / sides
    highest = np.full_like(x, -np.inf)
    for angle in angles:
        cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))
        np.maximum(highest, cos * x + sin * y, out=highest)
    return np.float32(apothem_mm) - highest


def _box(x: HeightMap, y: HeightMap, half_x: float, half_y: float, corner_mm: float) -> HeightMap:
    over_x, over_y = np.abs(x) - (half_x - corner_mm), np.abs(y) - (half_y - corner_mm)
    outside = hypot(np.maximum(over_x, 0), np.maximum(over_y, 0))
    return corner_mm - outside - np.minimum(np.maximum(over_x, over_y), 0)


def _segment(
    x: HeightMap, y: HeightMap, ax: float, ay: float, bx: float, by: float, half_mm: float
) -> HeightMap:
    """Return the distance inside a stroke of half-width `half_mm` from a to b."""
    dx, dy = bx - ax, by - ay
    along = ((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-9)
    along = np.clip(along, 0, 1)
    return (half_mm - hypot(x - ax - along * dx, y - ay - along * dy)).astype(np.float32)


def _crown(rng: np.random.Generator) -> np.float32:
    """Return a small random growth of an outline in mm."""
    return np.float32(rng.uniform(-0.3, 0.3))


_LETTERS = {
    "letter_l": ((-0.6, -1), (-0.6, 1), (0.7, 1)),
    "letter_z": ((-0.7, -1), (0.7, -1), (-0.7, 1), (0.7, 1)),
    "letter_n": ((-0.7, 1), (-0.7, -1), (0.7, 1), (0.7, -1)),
    "letter_f": ((-0.6, 1), (-0.6, 0), (0.3, 0), (-0.6, 0), (-0.6, -1), (0.7, -1)),
    "letter_r": ((-0.6, 1), (-0.6, -1), (0.5, -1), (0.5, 0), (-0.6, 0), (0.6, 1)),
    "digit_4": ((0.3, 1), (0.3, -1), (-0.8, 0.4), (0.8, 0.4)),
}

OUTLINES: dict[str, Indenter] = {
    **{
        f"prism_{sides}": Indenter(partial(prism, sides=sides, apothem_mm=size, fillet_mm=fillet))
        for sides, size, fillet in (
            (3, 2.0, 0.15),
            (4, 2.6, 0.3),
            (5, 2.8, 0.1),
            (6, 3.4, 0.5),
            (7, 3.0, 0.2),
            (8, 3.2, 0.4),
        )
    },
    "bar_narrow": Indenter(partial(plate, half_mm=(5, 0.5), corner_mm=0.2, fillet_mm=0.2)),
    "bar_wide": Indenter(partial(plate, half_mm=(5, 1.5), corner_mm=0.6, fillet_mm=0.3)),
    "block": Indenter(partial(plate, half_mm=(3.5, 2.5), corner_mm=0.8, fillet_mm=0.4)),
    "slab": Indenter(partial(plate, half_mm=(5, 4), corner_mm=1.5, fillet_mm=0.8)),
    "ring_flat": Indenter(partial(disc_ring, inner_mm=2.4, outer_mm=3.6)),
    "ring_thin": Indenter(partial(disc_ring, inner_mm=3.6, outer_mm=4.2)),
    "ring_open": Indenter(partial(disc_ring, inner_mm=2.2, outer_mm=3.2, gap_rad=1.2)),
    "arc": Indenter(partial(disc_ring, inner_mm=3.0, outer_mm=4.0, gap_rad=3.6)),
    "cross_3": Indenter(partial(cross, arms=3, length_mm=4.0, width_mm=1.2)),
    "cross_4": Indenter(partial(cross, arms=4, length_mm=4.0, width_mm=1.0)),
    "cross_5": Indenter(partial(cross, arms=5, length_mm=4.0, width_mm=0.7)),
    "gear_5": Indenter(partial(gear, teeth=5, radius_mm=3.2, tooth_mm=0.8)),
    "gear_9": Indenter(partial(gear, teeth=9, radius_mm=3.6, tooth_mm=0.5)),
    "gear_14": Indenter(partial(gear, teeth=14, radius_mm=4.2, tooth_mm=0.4)),
    "star_6": Indenter(partial(gear, teeth=6, radius_mm=2.8, tooth_mm=1.3)),
    "scribble_3": Indenter(partial(scribble, corners=3, width_mm=1.0)),
    "scribble_5": Indenter(partial(scribble, corners=5, width_mm=0.7)),
    "grating_coarse": Indenter(partial(grating, pitch_mm=2.4, duty=0.4), is_extended=True),
    "grating_fine": Indenter(partial(grating, pitch_mm=1.2, duty=0.5), is_extended=True),
    "studs_coarse": Indenter(partial(dots, pitch_mm=2.6, radius_mm=0.9), is_extended=True),
    "studs_fine": Indenter(partial(dots, pitch_mm=1.5, radius_mm=0.5), is_extended=True),
    "raised_print": Indenter(
        partial(dots, pitch_mm=2.3, radius_mm=0.75, missing=0.5), is_extended=True
    ),
    **{
        name: Indenter(partial(strokes, points=points, width_mm=0.9))
        for name, points in _LETTERS.items()
    },
}
"""Flat-faced bodies by name."""
