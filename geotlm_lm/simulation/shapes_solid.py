"""Smooth solids for training: balls, eggs, rods, cones, wedges, rings; formulas only."""

from __future__ import annotations

from functools import partial

import numpy as np

from geotlm_lm.simulation.indenter import HeightMap, Indenter, hypot, turned, where_solid


def ellipsoid(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, axes_mm: tuple[float, float, float]
) -> HeightMap:
    """Return the underside of an ellipsoid with half-axes (a, b, c)."""
    a, b, c = (axis * rng.uniform(0.85, 1.15) for axis in axes_mm)
    inside = 1 - (x / a) ** 2 - (y / b) ** 2
    return where_solid(c - c * np.sqrt(np.maximum(inside, 0)), inside > 0.02)


def superellipsoid(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, half_mm: float, power: float
) -> HeightMap:
    """Return a pillow: half_mm wide, squarer with a higher power."""
    aspect = rng.uniform(0.6, 1.0)
    ratio = np.abs(x / half_mm) ** power + np.abs(y / (half_mm * aspect)) ** power
    return where_solid(2.0 - 2.0 * np.sqrt(np.maximum(1 - ratio, 0)), ratio < 0.98)


def rod(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, radius_mm: float, length_mm: float
) -> HeightMap:
    """Return a lying rod with round ends (a capsule)."""
    radius = radius_mm * rng.uniform(0.8, 1.2)
    along = np.maximum(np.abs(x) - length_mm / 2, 0)
    square = radius**2 - along**2 - y**2
    return where_solid(radius - np.sqrt(np.maximum(square, 0)), square > 0.03 * radius**2)


def cone(
    x: HeightMap,
    y: HeightMap,
    rng: np.random.Generator,
    *,
    slope: float,
    tip_mm: float,
    stretch: float = 1.0,
) -> HeightMap:
    """Return a cone with a rounded tip; `stretch` makes it elliptic."""
    steepness = slope * rng.uniform(0.85, 1.2)
    square = (x / stretch) ** 2 + y**2
    return steepness * (np.sqrt(square + tip_mm**2) - tip_mm)


def pyramid(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, sides: int, slope: float, tip_mm: float
) -> HeightMap:
    """Return a pyramid with rounded edges: a soft maximum over its faces."""
    steepness = slope * rng.uniform(0.8, 1.2)
    angles = 2 * np.pi * np.arange(sides) / sides
    faces = [steepness * (np.cos(a) * x + np.sin(a) * y).astype(np.float32) for a in angles]
    highest = np.maximum.reduce(faces)
    soft = sum(np.exp(np.maximum((face - highest) / tip_mm, -30)) for face in faces)
    return (highest + tip_mm * np.log(soft)).astype(np.float32)


def roof(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, slope: float, edge_mm: float
) -> HeightMap:
    """Return a long rounded ridge whose two flanks differ in slope."""
    left, right = slope * rng.uniform(0.7, 1.3, 2)
    bend = rng.uniform(0, 0.03)
    ridge = np.sqrt(y**2 + edge_mm**2) - edge_mm
    return np.where(y > 0, right, left).astype(np.float32) * ridge + bend * x**2


def torus(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, ring_mm: float, tube_mm: float
) -> HeightMap:
    """Return a lying ring with a round cross-section."""
    ring = ring_mm * rng.uniform(0.85, 1.15)
    aspect = rng.uniform(0.75, 1.0)
    square = tube_mm**2 - (hypot(x, y / aspect) - ring) ** 2
    return where_solid(tube_mm - np.sqrt(np.maximum(square, 0)), square > 0.03 * tube_mm**2)


def saddle(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, radius_mm: float, waist_mm: float
) -> HeightMap:
    """Return a waisted or barrelled roller: its radius changes along its length."""
    radius = radius_mm + (x**2) / (2 * waist_mm) * rng.uniform(0.7, 1.3)
    square = radius**2 - y**2
    body = radius_mm - np.sqrt(np.maximum(square, 0))
    return where_solid(body, (square > 0.03 * radius_mm**2) & (np.abs(x) < 5))


def crossed_rods(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, count: int, radius_mm: float
) -> HeightMap:
    """Return rods that cross near the middle at random angles."""
    lowest = np.full_like(x, 1000.0)
    for index in range(count):
        u, v = turned(x, y, np.pi * (index + rng.uniform(-0.25, 0.25)) / count)
        offset = rng.uniform(-0.8, 0.8)
        one = rod(u, v - offset, rng, radius_mm=radius_mm, length_mm=14.0)
        lowest = np.minimum(lowest, one + np.float32(rng.uniform(0, 0.1)))
    return lowest


def stepped(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, *, step_mm: float, width_mm: float
) -> HeightMap:
    """Return a plate with a straight step across it, gently curved."""
    edge = rng.uniform(-1, 1)
    rise = step_mm / (1 + np.exp(-np.clip((y - edge) / width_mm, -30, 30)))
    return (rise + (x**2 + y**2) / (2 * rng.uniform(25, 60))).astype(np.float32)


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
}
"""Smooth solids by name."""
