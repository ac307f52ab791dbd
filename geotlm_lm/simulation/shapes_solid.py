"""Smooth solids and flat-faced outlines for training: balls, rods, prisms, letters, gratings."""

from __future__ import annotations

from functools import partial

import numpy as np

from geotlm_lm.simulation.shapes import Indenter, bowl, extrude, hypot, turned, where_solid


def ellipsoid(x, y, rng, *, axes_mm: tuple[float, float, float]):
    """Return the underside of an ellipsoid with half-axes (a, b, c)."""
    a, b, c = (axis * rng.uniform(0.85, 1.15) for axis in axes_mm)
    inside = 1 - (x / a) ** 2 - (y / b) ** 2
    return where_solid(c - c * np.sqrt(np.maximum(inside, 0)), inside > 0.02)


def superellipsoid(x, y, rng, *, half_mm: float, power: float):
    """Return a pillow: half_mm wide, squarer with a higher power."""
    aspect = rng.uniform(0.6, 1.0)
    ratio = np.abs(x / half_mm) ** power + np.abs(y / (half_mm * aspect)) ** power
    return where_solid(2.0 - 2.0 * np.sqrt(np.maximum(1 - ratio, 0)), ratio < 0.98)


def rod(x, y, rng, *, radius_mm: float, length_mm: float):
    """Return a lying rod with round ends (a capsule)."""
    radius = radius_mm * rng.uniform(0.8, 1.2)
    along = np.maximum(np.abs(x) - length_mm / 2, 0)
    square = radius**2 - along**2 - y**2
    return where_solid(radius - np.sqrt(np.maximum(square, 0)), square > 0.03 * radius**2)


def cone(x, y, rng, *, slope: float, tip_mm: float, stretch: float = 1.0):
    """Return a cone with a rounded tip; `stretch` makes it elliptic."""
    steepness = slope * rng.uniform(0.85, 1.2)
    square = (x / stretch) ** 2 + y**2
    return steepness * (np.sqrt(square + tip_mm**2) - tip_mm)


def pyramid(x, y, rng, *, sides: int, slope: float, tip_mm: float):
    """Return a pyramid with rounded edges: a soft maximum over its faces."""
    steepness = slope * rng.uniform(0.8, 1.2)
    angles = 2 * np.pi * np.arange(sides) / sides
    faces = [steepness * (np.cos(a) * x + np.sin(a) * y).astype(np.float32) for a in angles]
    highest = np.maximum.reduce(faces)
    soft = sum(np.exp(np.maximum((face - highest) / tip_mm, -30)) for face in faces)
    return (highest + tip_mm * np.log(soft)).astype(np.float32)


def roof(x, y, rng, *, slope: float, edge_mm: float):
    """Return a long rounded ridge whose two flanks differ in slope."""
    left, right = slope * rng.uniform(0.7, 1.3, 2)
    bend = rng.uniform(0, 0.03)
    ridge = np.sqrt(y**2 + edge_mm**2) - edge_mm
    return np.where(y > 0, right, left).astype(np.float32) * ridge + bend * x**2


def torus(x, y, rng, *, ring_mm: float, tube_mm: float):
    """Return a lying ring with a round cross-section."""
    ring = ring_mm * rng.uniform(0.85, 1.15)
    aspect = rng.uniform(0.75, 1.0)
    square = tube_mm**2 - (hypot(x, y / aspect) - ring) ** 2
    return where_solid(tube_mm - np.sqrt(np.maximum(square, 0)), square > 0.03 * tube_mm**2)


def saddle(x, y, rng, *, radius_mm: float, waist_mm: float):
    """Return a waisted or barrelled roller: its radius changes along its length."""
    radius = radius_mm + (x**2) / (2 * waist_mm) * rng.uniform(0.7, 1.3)
    square = radius**2 - y**2
    body = radius_mm - np.sqrt(np.maximum(square, 0))
    return where_solid(body, (square > 0.03 * radius_mm**2) & (np.abs(x) < 5))


def crossed_rods(x, y, rng, *, count: int, radius_mm: float):
    """Return rods that cross near the middle at random angles."""
    lowest = np.full_like(x, 1000.0)
    for index in range(count):
        u, v = turned(x, y, np.pi * (index + rng.uniform(-0.25, 0.25)) / count)
        offset = rng.uniform(-0.8, 0.8)
        one = rod(u, v - offset, rng, radius_mm=radius_mm, length_mm=14.0)
        lowest = np.minimum(lowest, one + np.float32(rng.uniform(0, 0.1)))
    return lowest


def stepped(x, y, rng, *, step_mm: float, width_mm: float):
    """Return a plate with a straight step across it, gently curved."""
    edge = rng.uniform(-1, 1)
    rise = step_mm / (1 + np.exp(-np.clip((y - edge) / width_mm, -30, 30)))
    return (rise + (x**2 + y**2) / (2 * rng.uniform(25, 60))).astype(np.float32)


def prism(x, y, rng, *, sides: int, apothem_mm: float, fillet_mm: float):
    """Return a regular prism standing on its end; `apothem_mm` is the inner radius."""
    highest = np.full_like(x, -np.inf)
    for angle in 2 * np.pi * np.arange(sides) / sides:
        cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))
        np.maximum(highest, cos * x + sin * y, out=highest)
    growth = np.float32(rng.uniform(-0.3, 0.3))
    return extrude(np.float32(apothem_mm) - highest + growth, fillet_mm)


def plate(x, y, rng, *, half_mm: tuple[float, float], corner_mm: float, fillet_mm: float):
    """Return a rectangular plate with round corners."""
    half_x, half_y = (np.array(half_mm) * rng.uniform(0.8, 1.2, 2)).tolist()
    over_x, over_y = np.abs(x) - (half_x - corner_mm), np.abs(y) - (half_y - corner_mm)
    outside = hypot(np.maximum(over_x, 0), np.maximum(over_y, 0))
    return extrude(corner_mm - outside - np.minimum(np.maximum(over_x, over_y), 0), fillet_mm)


def disc_ring(x, y, rng, *, inner_mm: float, outer_mm: float, gap_rad: float = 0.0):
    """Return a flat ring, with a gap when `gap_rad` > 0; oval by chance."""
    oval = rng.uniform(0.75, 1.0)
    radius = hypot(x, y / oval)
    inside = np.minimum(outer_mm - radius, radius - inner_mm)
    if gap_rad > 0:
        opening = (np.abs(np.arctan2(y, x)) - gap_rad / 2) * radius
        inside = np.minimum(inside, opening)
    return extrude(inside, 0.25)


def cross(x, y, rng, *, arms: int, length_mm: float, width_mm: float):
    """Return bars from the middle outwards; unequal lengths by chance."""
    inside = np.full_like(x, -1e3)
    width = width_mm * rng.uniform(0.8, 1.3)
    for index in range(arms):
        u, v = turned(x, y, 2 * np.pi * index / arms)
        reach = length_mm * rng.uniform(0.7, 1.2)
        inside = np.maximum(inside, _segment(u, v, 0, 0, reach, 0, width / 2))
    return extrude(inside, min(0.25, 0.45 * width))


def gear(x, y, rng, *, teeth: int, radius_mm: float, tooth_mm: float):
    """Return a wheel whose rim waves `teeth` times, sharper by chance."""
    angle, radius = np.arctan2(y, x), hypot(x, y)
    sharp = rng.uniform(1.0, 4.0)
    rim = radius_mm + tooth_mm * np.tanh(sharp * np.cos(teeth * angle)) / float(np.tanh(sharp))
    inside = (rim - radius) * 0.8
    if rng.random() < 0.4:
        inside = np.minimum(inside, radius - 0.4 * radius_mm)
    return extrude(inside, 0.2)


def strokes(x, y, rng, *, points: tuple[tuple[float, float], ...], width_mm: float):
    """Return a raised letter: a pen drawn from point to point, in units of 3 mm."""
    inside = np.full_like(x, -1e3)
    slant = rng.uniform(-0.3, 0.3)
    reach = 3.0 * rng.uniform(0.8, 1.2)
    for (ax, ay), (bx, by) in zip(points[:-1], points[1:], strict=True):
        ends = ((ax + slant * ay) * reach, ay * reach, (bx + slant * by) * reach, by * reach)
        inside = np.maximum(inside, _segment(x, y, *ends, width_mm / 2))
    return extrude(inside, 0.3 * width_mm)


def scribble(x, y, rng, *, corners: int, width_mm: float):
    """Return a bent wire through random points."""
    points = tuple((float(a), float(b)) for a, b in rng.uniform(-1.4, 1.4, (corners, 2)))
    return strokes(x, y, rng, points=points, width_mm=width_mm)


def grating(x, y, rng, *, pitch_mm: float, duty: float):
    """Return parallel bars on a gently curved back."""
    pitch = pitch_mm * rng.uniform(0.8, 1.25)
    wave = np.abs((y / pitch + rng.uniform()) % 1.0 - 0.5) * pitch
    groove = np.clip((wave - duty * pitch / 2) * 2.0, 0, 0.5)
    return groove.astype(np.float32) + bowl(x, y, rng.uniform(20, 70))


def dots(x, y, rng, *, pitch_mm: float, radius_mm: float, missing: float = 0.0):
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


def _segment(x, y, ax: float, ay: float, bx: float, by: float, half_mm: float):
    """Return the distance inside a stroke of half-width `half_mm` from a to b."""
    dx, dy = bx - ax, by - ay
    along = ((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-9)
    along = np.clip(along, 0, 1)
    return (half_mm - hypot(x - ax - along * dx, y - ay - along * dy)).astype(np.float32)


_LETTERS = {
    "letter_l": ((-0.6, -1), (-0.6, 1), (0.7, 1)),
    "letter_z": ((-0.7, -1), (0.7, -1), (-0.7, 1), (0.7, 1)),
    "letter_n": ((-0.7, 1), (-0.7, -1), (0.7, 1), (0.7, -1)),
    "letter_f": ((-0.6, 1), (-0.6, 0), (0.3, 0), (-0.6, 0), (-0.6, -1), (0.7, -1)),
    "letter_r": ((-0.6, 1), (-0.6, -1), (0.5, -1), (0.5, 0), (-0.6, 0), (0.6, 1)),
    "digit_4": ((0.3, 1), (0.3, -1), (-0.8, 0.4), (0.8, 0.4)),
}

SOLIDS: dict[str, Indenter] = {
    "ball_small": Indenter(partial(ellipsoid, axes_mm=(2.5, 2.5, 2.5)), is_axisymmetric=True),
    "ball_medium": Indenter(partial(ellipsoid, axes_mm=(4, 4, 4)), is_axisymmetric=True),
    "ball_large": Indenter(partial(ellipsoid, axes_mm=(8, 8, 8)), is_axisymmetric=True),
    "ball_huge": Indenter(partial(ellipsoid, axes_mm=(25, 25, 25)), is_axisymmetric=True),
    "egg": Indenter(partial(ellipsoid, axes_mm=(7, 4.5, 4.5))),
    "pebble": Indenter(partial(ellipsoid, axes_mm=(5, 3.2, 2.0))),
    "rice": Indenter(partial(ellipsoid, axes_mm=(4.5, 1.6, 1.6))),
    "lens": Indenter(partial(ellipsoid, axes_mm=(9, 7, 2.5))),
    "pillow": Indenter(partial(superellipsoid, half_mm=4.0, power=4)),
    "cushion": Indenter(partial(superellipsoid, half_mm=5.0, power=8)),
    "rod_thin": Indenter(partial(rod, radius_mm=1.0, length_mm=12)),
    "rod_thick": Indenter(partial(rod, radius_mm=3.5, length_mm=9)),
    "rod_long": Indenter(partial(rod, radius_mm=2.0, length_mm=24)),
    "pill": Indenter(partial(rod, radius_mm=2.4, length_mm=4)),
    "cone_blunt": Indenter(partial(cone, slope=0.35, tip_mm=1.2), is_axisymmetric=True),
    "cone_sharp": Indenter(partial(cone, slope=0.7, tip_mm=0.4), is_axisymmetric=True),
    "cone_elliptic": Indenter(partial(cone, slope=0.5, tip_mm=0.5, stretch=2.0)),
    "pyramid_3": Indenter(partial(pyramid, sides=3, slope=0.35, tip_mm=0.10)),
    "pyramid_4": Indenter(partial(pyramid, sides=4, slope=0.30, tip_mm=0.06)),
    "pyramid_5": Indenter(partial(pyramid, sides=5, slope=0.30, tip_mm=0.05)),
    "roof_flat": Indenter(partial(roof, slope=0.3, edge_mm=0.4)),
    "roof_sharp": Indenter(partial(roof, slope=0.8, edge_mm=0.25)),
    "ring_round": Indenter(partial(torus, ring_mm=4.0, tube_mm=1.2)),
    "ring_small": Indenter(partial(torus, ring_mm=2.2, tube_mm=0.8)),
    "roller_waisted": Indenter(partial(saddle, radius_mm=3.0, waist_mm=80)),
    "roller_barrel": Indenter(partial(saddle, radius_mm=4.0, waist_mm=-30)),
    "rods_crossed_2": Indenter(partial(crossed_rods, count=2, radius_mm=1.2)),
    "rods_crossed_3": Indenter(partial(crossed_rods, count=3, radius_mm=1.0)),
    "step_low": Indenter(partial(stepped, step_mm=0.3, width_mm=0.15)),
    "step_high": Indenter(partial(stepped, step_mm=0.8, width_mm=0.12)),
    "prism_3": Indenter(partial(prism, sides=3, apothem_mm=2.0, fillet_mm=0.15)),
    "prism_4": Indenter(partial(prism, sides=4, apothem_mm=2.6, fillet_mm=0.3)),
    "prism_5": Indenter(partial(prism, sides=5, apothem_mm=2.8, fillet_mm=0.1)),
    "prism_6": Indenter(partial(prism, sides=6, apothem_mm=3.4, fillet_mm=0.5)),
    "prism_7": Indenter(partial(prism, sides=7, apothem_mm=3.0, fillet_mm=0.2)),
    "prism_8": Indenter(partial(prism, sides=8, apothem_mm=3.2, fillet_mm=0.4)),
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
"""Smooth solids and flat-faced bodies by name."""
