"""Bodies composed at random for training: no two of a kind are alike; formulas only.

A model that meets each body in one form learns the forms. Measured on the bundle trained without
these: 0.945 of motions told on new clips of bodies it knew, 0.91 on bodies it had not met.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from geotlm_lm.simulation.indenter import HeightMap, Indenter, bowl, extrude, hypot, turned
from geotlm_lm.simulation.relief import picture, polar, strokes, to_nearest, within

Random = np.random.Generator


def face(
    x: HeightMap,
    y: HeightMap,
    rng: Random,
    *,
    size_mm: tuple[float, float],
    roundness: float = 1.0,
    marks: int = 3,
) -> HeightMap:
    """Return a flat or crowned face over a random outline, with random marks on it.

    Args:
        x: Coordinate to the right, mm.
        y: Coordinate down, mm.
        rng: Draws outline and marks.
        size_mm: Range of its mean radius.
        roundness: Share of faces whose outline is a circle.
        marks: Most marks on it.
    """
    size, (angle, radius) = rng.uniform(*size_mm), polar(x, y)
    outline = size if rng.random() < roundness else _free_outline(rng, angle, size)
    if rng.random() < 0.3:  # a milled or toothed edge
        teeth = int(rng.integers(8, 60))
        outline = outline + np.float32(rng.uniform(0.1, 1.2) / teeth**0.5) * np.cos(teeth * angle)
    height = extrude(outline - radius, rng.uniform(0.1, 0.7))
    if rng.random() < 0.4:
        height = height + bowl(x, y, np.exp(rng.uniform(np.log(15), np.log(200))))
    for _ in range(int(rng.integers(1, marks + 1))):
        mark = _MARKS[int(rng.integers(len(_MARKS)))]
        rise = rng.uniform(0.04, 0.25) * (1 if rng.random() < 0.6 else -1)
        height = height - np.float32(rise) * mark(x, y, rng, size)
    return height.astype(np.float32)


def beveled_edge(x: HeightMap, y: HeightMap, rng: Random, *, bend_mm: float) -> HeightMap:
    """Return a long edge of two or three flat faces, straight or bent, nicked by chance."""
    off = _off_line(x, y, rng, bend_mm)
    rising, falling = rng.uniform(0.0, 0.25), np.exp(rng.uniform(np.log(0.3), np.log(6)))
    height = np.maximum(-rising * off, falling * off)
    if rng.random() < 0.5:
        chamfer = rng.uniform(0.2, 0.8)
        height = np.maximum(height, 0.5 * (falling - rising) * off + 0.3 * falling * chamfer)
    return (height + _nicks(x, rng, off)).astype(np.float32)


def wall(x: HeightMap, y: HeightMap, rng: Random, *, bend_mm: float) -> HeightMap:
    """Return a wall standing on its narrow side, straight or bent, its flanks of unlike slope."""
    off = _off_line(x, y, rng, bend_mm)
    half = rng.uniform(0.2, 1.2)
    inside, outside = np.maximum(off - half, 0), np.maximum(-off - half, 0)
    slopes = np.exp(rng.uniform(np.log(0.8), np.log(8), 2))
    crown = np.float32(rng.uniform(0, 0.3)) * np.square(off / half)
    height = slopes[0] * inside + slopes[1] * outside + np.minimum(crown, 0.5)
    return (height + _nicks(x, rng, off)).astype(np.float32)


def facets(x: HeightMap, y: HeightMap, rng: Random, *, faces: tuple[int, int]) -> HeightMap:
    """Return the underside of a cut stone: the upper hull of random planes, edges rounded."""
    count = int(rng.integers(*faces))
    around = rng.uniform(0, 2 * np.pi) + np.arange(count) * 2 * np.pi / count
    around = around + rng.uniform(-0.6, 0.6, count) * np.pi / count
    sharpness = np.float32(rng.uniform(8, 40))
    total = np.zeros_like(x)
    for angle in around:
        slope, level = np.exp(rng.uniform(np.log(0.12), np.log(1.0))), rng.uniform(-0.4, 0.0)
        plane = slope * (np.cos(angle) * x + np.sin(angle) * y) + level
        total = total + np.exp(np.clip(sharpness * plane.astype(np.float32), -60, 60))
    return np.log(total + np.float32(1e-6)) / sharpness


def marked_rod(
    x: HeightMap, y: HeightMap, rng: Random, *, radius_mm: tuple[float, float]
) -> HeightMap:
    """Return a rod lying on its side with collars, flats or engraved strokes."""
    radius = np.exp(rng.uniform(*np.log(radius_mm)))
    taper = np.float32(rng.uniform(0, 0.08)) * np.abs(x)
    back = np.square(y) * np.float32(0.5 / radius) + taper
    if rng.random() < 0.5:
        back = np.maximum(back, rng.uniform(0.02, 0.3))  # a flat, filed along it
    for place in rng.uniform(-7, 7, rng.integers(0, 4)):
        collar = within(np.abs(x - np.float32(place)), rng.uniform(0.2, 1.2), 0.15)
        back = back + np.float32(rng.uniform(-0.15, 0.3)) * collar
    writing = strokes(x, y, rng, count=int(rng.integers(0, 6)), reach_mm=4.0)
    ends = 2.0 * np.square(np.maximum(np.abs(x) - rng.uniform(3, 11), 0))
    return (back + rng.uniform(-0.2, 0.2) * writing + ends).astype(np.float32)


def _free_outline(rng: Random, angle: HeightMap, size_mm: float) -> HeightMap:
    """Return the radius of a random closed curve or polygon in every direction, mm."""
    if rng.random() < 0.5:
        sides = int(rng.integers(3, 9))
        stretch = rng.uniform(0.6, 1.0)
        aspect = hypot(np.cos(angle), np.sin(angle) / stretch)
        return np.float32(size_mm) / (np.cos(to_nearest(angle, sides)) * aspect)
    waves = np.ones_like(angle)
    for order in range(1, 6):
        weight = rng.normal(0, 0.25 / order)
        waves = waves + np.float32(weight) * np.cos(order * angle + np.float32(rng.uniform(0, 6.3)))
    return np.float32(size_mm) * np.maximum(waves, 0.3)


def _off_line(x: HeightMap, y: HeightMap, rng: Random, bend_mm: float) -> HeightMap:
    """Return the distance from a line, or from a circle of `bend_mm` or wider, through 0."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    if rng.random() < 0.35:
        return v
    bend = bend_mm * np.exp(rng.uniform(0, np.log(5)))
    return hypot(u, v + np.float32(bend)) - np.float32(bend)


def _nicks(x: HeightMap, rng: Random, off: HeightMap) -> HeightMap:
    """Return what is cut from an edge here and there, and a slow unevenness along it."""
    uneven = np.float32(rng.uniform(0, 0.03)) * picture(x, rng, scale_mm=rng.uniform(0.8, 4.0))
    cut = np.zeros_like(x)
    for place in rng.uniform(-8, 8, rng.integers(0, 4)):
        width = rng.uniform(0.2, 0.8)
        cut = cut + within(np.abs(x - np.float32(place)), width, 0.2) * (np.abs(off) < 3)
    return uneven + np.float32(rng.uniform(0.05, 0.4)) * cut


def _border(x: HeightMap, y: HeightMap, rng: Random, size_mm: float) -> HeightMap:
    return 1 - within(hypot(x, y), rng.uniform(0.7, 0.95) * size_mm, rng.uniform(0.1, 0.5))


def _circle(x: HeightMap, y: HeightMap, rng: Random, size_mm: float) -> HeightMap:
    off = np.abs(hypot(x, y) - rng.uniform(0.2, 0.9) * size_mm)
    return within(off, rng.uniform(0.1, 0.5), 0.15)


def _spots(x: HeightMap, y: HeightMap, rng: Random, size_mm: float) -> HeightMap:
    angle, radius = polar(x, y)
    circle, count = rng.uniform(0.3, 0.95) * size_mm, int(rng.integers(2, 60))
    off = to_nearest(angle, count)
    away = hypot(radius * np.cos(off) - circle, radius * np.sin(off))
    return within(away, min(rng.uniform(0.15, 1.2), 2.0 * circle / count), 0.12)


def _rays(x: HeightMap, y: HeightMap, rng: Random, size_mm: float) -> HeightMap:
    angle, radius = polar(x, y)
    off_mm = np.abs(to_nearest(angle, int(rng.integers(1, 40)))) * radius
    inner, outer = np.sort(rng.uniform(0, 1, 2)) * size_mm
    return within(off_mm, rng.uniform(0.1, 0.4), 0.1) * ((radius > inner) & (radius < outer))


def _writing(x: HeightMap, y: HeightMap, rng: Random, size_mm: float) -> HeightMap:
    return strokes(x, y, rng, count=int(rng.integers(1, 9)), reach_mm=0.7 * size_mm)


def _picture(x: HeightMap, y: HeightMap, rng: Random, size_mm: float) -> HeightMap:
    inside = within(hypot(x, y), rng.uniform(0.5, 1.0) * size_mm, 0.5)
    return 0.6 * inside * picture(x, rng, scale_mm=rng.uniform(0.5, 3.0))


_MARKS = (_border, _circle, _spots, _rays, _writing, _picture)

FREE: dict[str, Indenter] = {
    "face_tiny": Indenter(partial(face, size_mm=(2.0, 3.5), roundness=0.6)),
    "face_small": Indenter(partial(face, size_mm=(3.0, 5.0), roundness=0.6)),
    "face_medium": Indenter(partial(face, size_mm=(4.5, 7.0), roundness=0.8)),
    "face_large": Indenter(partial(face, size_mm=(6.5, 9.5))),
    "face_wide": Indenter(partial(face, size_mm=(9.0, 12.0), marks=5)),
    "face_rich": Indenter(partial(face, size_mm=(4.0, 10.0), marks=6)),
    "face_bare": Indenter(partial(face, size_mm=(3.0, 9.0), marks=1)),
    "face_free": Indenter(partial(face, size_mm=(2.5, 7.0), roundness=0.0, marks=2)),
    "face_angular": Indenter(partial(face, size_mm=(3.0, 6.0), roundness=0.0, marks=4)),
    "edge_beveled": Indenter(partial(beveled_edge, bend_mm=20.0)),
    "edge_bent": Indenter(partial(beveled_edge, bend_mm=6.0)),
    "wall_wide": Indenter(partial(wall, bend_mm=15.0)),
    "wall_bent": Indenter(partial(wall, bend_mm=5.0)),
    "facets_few": Indenter(partial(facets, faces=(3, 5))),
    "facets_many": Indenter(partial(facets, faces=(5, 9))),
    "rod_marked": Indenter(partial(marked_rod, radius_mm=(0.8, 3.0))),
    "rod_collared": Indenter(partial(marked_rod, radius_mm=(2.0, 8.0))),
}
"""Bodies composed at random, by name."""
