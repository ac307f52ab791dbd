"""Round bodies for training that a hand turns: lids, knobs, dials, medals, wheels, plugs.

Their outline looks the same after a turn; what tells it is fine relief inside a strong rim, and a
part of that rim is often all that touches. Lengths in mm; a recess is a positive height.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from geotlm_lm.simulation.indenter import HeightMap, Indenter, bowl, extrude, hypot
from geotlm_lm.simulation.relief import picture, polar, strokes, to_nearest, within

Random = np.random.Generator


def button(x: HeightMap, y: HeightMap, rng: Random, *, holes: int) -> HeightMap:
    """Return a sewn button: raised border, sunken middle, a few holes."""
    size, (angle, radius) = rng.uniform(4.0, 7.5), polar(x, y)
    middle = rng.uniform(0.1, 0.4) * within(radius, 0.7 * size, 0.6)
    off = to_nearest(angle, holes)
    away = hypot(radius * np.cos(off) - 0.25 * size, radius * np.sin(off))
    return extrude(size - radius, 0.4) + middle + 0.8 * within(away, 0.11 * size, 0.1)


def medal(x: HeightMap, y: HeightMap, rng: Random, *, least_mm: float, most_mm: float) -> HeightMap:
    """Return a disc with a picture in low relief, within a border by chance."""
    size, radius = rng.uniform(least_mm, most_mm), hypot(x, y)
    drawn = picture(x, rng, scale_mm=rng.uniform(0.7, 2.5))
    height = rng.uniform(0.03, 0.12) * drawn
    if rng.random() < 0.6:
        border = rng.uniform(0.5, 1.5)
        height = np.where(radius < size - border, height + rng.uniform(0.0, 0.25), 0.0)
    return extrude(size - radius, rng.uniform(0.1, 0.6)) + height.astype(np.float32)


def lid(x: HeightMap, y: HeightMap, rng: Random, *, least_mm: float, most_mm: float) -> HeightMap:
    """Return a jar's lid: steps between circles, a few raised strokes, ribs on its edge."""
    size, (angle, radius) = rng.uniform(least_mm, most_mm), polar(x, y)
    ribs = rng.integers(0, 50)
    edge = size + rng.uniform(0.05, 0.2) * np.cos(ribs * angle) * (ribs > 10)
    height = extrude(edge - radius, rng.uniform(0.3, 1.0))
    for share in rng.uniform(0.5, 0.95, rng.integers(1, 3)):
        height = height + rng.uniform(-0.1, 0.3) * within(radius, share * size, 0.3)
    writing = strokes(x, y, rng, count=int(rng.integers(2, 7)), reach_mm=0.5 * size)
    return (height - rng.uniform(0.05, 0.2) * writing).astype(np.float32)


def knob(x: HeightMap, y: HeightMap, rng: Random, *, flutes: Sequence[int]) -> HeightMap:
    """Return a handle's end: hollows around its edge, a crowned top, a mark by chance."""
    size, (angle, radius) = rng.uniform(4.0, 9.0), polar(x, y)
    count = int(rng.choice(flutes))
    hollow = rng.uniform(0.4, 1.6) * size / count * np.abs(np.cos(count * angle / 2)) ** 3
    crown = bowl(x, y, rng.uniform(30, 150))
    pointer = (np.abs(y) < rng.uniform(0.25, 0.5)) & (x > rng.uniform(0, 0.6) * size)
    mark = float(rng.choice([0.0, 0.3, -0.15])) * pointer
    return extrude(size - hollow - radius, 0.3) + crown + mark.astype(np.float32)


def toothed_washer(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a ring whose face is cut into radial teeth."""
    outer, (angle, radius) = rng.uniform(4.0, 8.0), polar(x, y)
    inside = np.minimum(outer - radius, radius - rng.uniform(0.45, 0.7) * outer)
    saw = (rng.integers(8, 30) * angle / (2 * np.pi) + rng.uniform()) % 1.0
    return extrude(inside, 0.2) + np.float32(rng.uniform(0.1, 0.35)) * saw.astype(np.float32)


def bolt(x: HeightMap, y: HeightMap, rng: Random, *, sides: int) -> HeightMap:
    """Return a bolt's head of `sides` sides, chamfered, with strokes that tell its grade."""
    size, (angle, radius) = rng.uniform(3.5, 6.0), polar(x, y)
    across = radius * np.cos(to_nearest(angle, sides))
    chamfer = rng.uniform(0.3, 0.7) * np.maximum(radius - 0.95 * size, 0)
    writing = strokes(x, y, rng, count=int(rng.integers(0, 5)), reach_mm=0.7 * size)
    height = extrude(size - across, 0.15) + chamfer - rng.uniform(0.05, 0.2) * writing
    return height.astype(np.float32)


def slotted_plug(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a plug with one slot for a blade, flat or crowned."""
    size, radius = rng.uniform(3.0, 8.0), hypot(x, y)
    slot = 0.8 * (np.abs(y) < rng.uniform(0.3, 0.8)) * (np.abs(x) < rng.uniform(0.5, 1.1) * size)
    return extrude(size - radius, 0.3) + bowl(x, y, rng.uniform(12, 100)) + slot.astype(np.float32)


def dial(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a scale: raised radial ticks over a part of the circle, every few a long one."""
    size, (angle, radius) = rng.uniform(5.0, 11.0), polar(x, y)
    count, sweep = int(rng.integers(12, 50)), rng.uniform(0.6, 1.0) * np.pi
    place = angle * count / (2 * np.pi)
    off_mm = np.abs(place - np.round(place)) * 2 * np.pi / count * radius
    is_long = np.round(place) % rng.integers(3, 6) == 0
    length = np.where(is_long, 0.25, 0.12) * size
    tick = (off_mm < 0.2) & (radius > 0.92 * size - length) & (radius < 0.92 * size)
    tick &= np.abs(angle) < sweep
    rise = rng.uniform(0.08, 0.25) * float(rng.choice([-1.0, 1.0]))
    return extrude(size - radius, 0.3) - (rise * tick).astype(np.float32)


def chip(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a gaming chip: blocks along its border, a ring and a small picture inside."""
    size, (angle, radius) = rng.uniform(6.0, 11.0), polar(x, y)
    blocks = np.cos(rng.integers(4, 12) * angle) > rng.uniform(-0.5, 0.5)
    border = (radius > 0.78 * size) * blocks * rng.uniform(0.08, 0.25)
    ring = rng.uniform(0.05, 0.2) * (np.abs(radius - 0.6 * size) < 0.3)
    writing = strokes(x, y, rng, count=3, reach_mm=0.35 * size)
    height = border - ring - rng.uniform(0.05, 0.15) * writing
    return extrude(size - radius, 0.25) + height.astype(np.float32)


def grate(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a drain's cover: holes on circles about its middle."""
    size, pitch, (angle, radius) = rng.uniform(5.0, 10.0), rng.uniform(1.6, 2.6), polar(x, y)
    circle = np.round(radius / pitch)
    off = to_nearest(angle, np.maximum(np.round(rng.uniform(3.0, 6.0) * circle), 1))
    away = hypot(radius * np.cos(off) - circle * pitch, radius * np.sin(off))
    holes = within(away, 0.5, 0.15) * (circle * pitch < 0.85 * size)
    return extrude(size - radius, 0.4) + 0.6 * holes.astype(np.float32)


def spoked_wheel(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a valve's wheel: a rim, spokes and a hub; the spokes lie lower by chance."""
    size, (angle, radius) = rng.uniform(4.5, 9.0), polar(x, y)
    spokes = int(rng.integers(2, 7))
    off = np.abs(np.sin(to_nearest(angle, spokes))) * radius
    spoke = np.minimum(rng.uniform(0.4, 0.8) - off, size - radius)
    rim = np.minimum(size - radius, radius - rng.uniform(0.75, 0.88) * size)
    hub = rng.uniform(0.2, 0.35) * size - radius
    lower = np.where(np.maximum(rim, hub) > 0, 0.0, rng.uniform(0.0, 0.3))
    return extrude(np.maximum(np.maximum(rim, hub), spoke), 0.2) + lower.astype(np.float32)


def seal(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a round ring with moulding nubs and a parting line that leaves the circle."""
    ring, tube, (angle, radius) = rng.uniform(3.0, 9.0), rng.uniform(0.5, 1.4), polar(x, y)
    off = radius - ring
    height = tube - np.sqrt(np.maximum(tube**2 - off**2, 0)) + 3 * np.maximum(np.abs(off) - tube, 0)
    for place in rng.uniform(-np.pi, np.pi, rng.integers(1, 4)):
        away = hypot(off, ring * to_nearest(angle - np.float32(place), 1))
        height = height - rng.uniform(0.05, 0.2) * within(away, rng.uniform(0.3, 0.8), 0.2)
    return height.astype(np.float32)


def notched_shaft(x: HeightMap, y: HeightMap, rng: Random) -> HeightMap:
    """Return a shaft's end with a flat, a keyway, and rings left by the lathe."""
    size, radius = rng.uniform(2.5, 7.0), hypot(x, y)
    inside = np.minimum(size - radius, rng.uniform(0.6, 1.0) * size - x)
    keyway = np.minimum(rng.uniform(0.3, 0.9) - np.abs(y), -x - rng.uniform(0.5, 0.8) * size)
    rings = rng.uniform(0, 0.02) * np.cos(2 * np.pi * radius / rng.uniform(0.4, 0.8))
    return extrude(np.minimum(inside, -keyway), 0.2) + rings.astype(np.float32)


ROUND: dict[str, Indenter] = {
    "button_2": Indenter(partial(button, holes=2)),
    "button_4": Indenter(partial(button, holes=4)),
    "medal_small": Indenter(partial(medal, least_mm=4.0, most_mm=7.0)),
    "medal_large": Indenter(partial(medal, least_mm=7.0, most_mm=12.0)),
    "lid_small": Indenter(partial(lid, least_mm=5.0, most_mm=8.0)),
    "lid_large": Indenter(partial(lid, least_mm=8.0, most_mm=12.5)),
    "knob_lobed": Indenter(partial(knob, flutes=(3, 4, 5, 7, 8))),
    "knob_fluted": Indenter(partial(knob, flutes=(12, 16, 20, 24, 30))),
    "toothed_washer": Indenter(toothed_washer),
    "bolt_square": Indenter(partial(bolt, sides=4)),
    "bolt_five": Indenter(partial(bolt, sides=5)),
    "bolt_eight": Indenter(partial(bolt, sides=8)),
    "slotted_plug": Indenter(slotted_plug),
    "dial": Indenter(dial),
    "chip": Indenter(chip),
    "grate": Indenter(grate),
    "spoked_wheel": Indenter(spoked_wheel),
    "seal": Indenter(seal),
    "notched_shaft": Indenter(notched_shaft),
}
"""Round bodies by name."""
