"""Every body by name, and twelve everyday things that no training uses.

A body is a formula for its underside (`shapes.HeightFormula`) with its own random features. No
formula of the everyday things is in a training body.
"""

from __future__ import annotations

import numpy as np

from geotlm_lm.core.errors import UsageError, choice_of
from geotlm_lm.simulation.shapes import Indenter, extrude, hypot, where_solid
from geotlm_lm.simulation.shapes_round import FACES
from geotlm_lm.simulation.shapes_solid import SOLIDS
from geotlm_lm.simulation.shapes_surface import SURFACES


def bottle_cap(x, y, rng):
    """Return a screw cap's top: a shallow dished disc with a knurled rim."""
    angle, radius = np.arctan2(y, x), hypot(x, y)
    rim = 6.5 + 0.12 * np.cos(60 * angle)
    dish = 0.25 * np.clip((5.2 - radius) / 0.8, 0, 1) ** 2
    logo = 0.1 * (np.abs(np.sin(1.1 * x + rng.uniform(0, 3))) * np.abs(y) < 0.35)
    return extrude(rim - radius, 0.6) + (dish - logo * (radius < 4)).astype(np.float32)


def key(x, y, rng):
    """Return a flat key: a round bow with a hole, a milled blade with cuts on one side."""
    bow = np.minimum(3.6 - hypot(x + 5, y), hypot(x + 6, y) - 1.0)
    cuts = np.interp(x, np.linspace(-1, 10, 9), rng.uniform(0.0, 1.0, 9)).astype(np.float32)
    blade = np.minimum(np.minimum(1.5 + y, 1.5 - cuts - y), np.minimum(10 - x, x + 3))
    groove = 0.3 * (np.abs(y + 0.6) < 0.3) * (x > -1)
    return extrude(np.maximum(bow, blade), 0.15) + groove.astype(np.float32)


def hex_nut(x, y, rng):
    """Return a nut's face: hexagon, bore, chamfers on both."""
    across = np.maximum(np.abs(y), np.abs(x) * 0.8660254 + np.abs(y) * 0.5)
    radius = hypot(x, y)
    inside = np.minimum(4.0 - across, radius - rng.uniform(2.2, 2.6))
    chamfer = 0.5 * np.maximum(radius - 3.9, 0)
    return extrude(inside, 0.2) + chamfer.astype(np.float32)


def screw_head(x, y, rng):
    """Return a domed head with a cross recess."""
    radius = hypot(x, y)
    dome = radius**2 / 18
    cross = np.minimum(np.abs(x), np.abs(y)) < 0.45
    recess = 1.2 * (cross & (np.maximum(np.abs(x), np.abs(y)) < rng.uniform(1.6, 2.1)))
    return where_solid((dome + recess).astype(np.float32), radius < 3.8)


def coin(x, y, rng):
    """Return a coin's face: raised rim, beaded border, a worn portrait in relief."""
    angle, radius = np.arctan2(y, x), hypot(x, y)
    face = 0.14 * np.clip((8.2 - radius) / 0.3, 0, 1)
    beads = 0.08 * (np.cos(70 * angle) > 0.2) * (np.abs(radius - 7.6) < 0.3)
    head = 1 - ((x - 0.5) / 2.6) ** 2 - ((y + 0.4) / 3.6) ** 2
    hair = np.abs(np.sin(2.2 * x + 1.5 * np.sin(y + rng.uniform(0, 3))))
    relief = 0.13 * np.sqrt(np.maximum(head, 0)) * (0.6 + 0.4 * hair)
    return extrude(9.0 - radius, 0.2) + (face - beads - relief).astype(np.float32)


def bead(x, y, rng):
    """Return an engraved cylindrical bead lying on its side, drilled lengthwise."""
    body = 2.8 - np.sqrt(np.maximum(2.8**2 - y**2, 0))
    groove = 0.25 * (np.cos(2 * np.pi * x / 1.6) > 0.7)
    zigzag = np.abs((x / 1.6 + rng.uniform()) % 1 - 0.5) * 1.6
    engraved = 0.18 * (np.abs(y - zigzag) < 0.2)
    end = 2.0 * np.maximum(np.abs(x) - 3.0, 0) ** 2
    solid = (np.abs(x) < 3.8) & (np.abs(y) < 2.75)
    return where_solid((body + groove + engraved + end).astype(np.float32), solid)


def pen_clip(x, y, rng):
    """Return a pocket clip: a long tapering tongue, its end bent towards the touch."""
    width = 0.8 + 0.05 * (x + 8)
    inside = np.minimum(width - np.abs(y), np.minimum(x + 8, 8 - x))
    bend = 0.5 * np.clip(np.abs(x + 6) / 3, 0, 1) ** 2 * (x > -6)
    rib = 0.15 * (np.abs(y) < 0.25) * (x > rng.uniform(-2, 1))
    return extrude(inside, 0.35) + (bend - rib).astype(np.float32)


def textured_ball(x, y, rng):
    """Return a dimpled ball: round hollows in a hexagonal lattice over a sphere."""
    square = np.maximum(36 - x * x - y * y, 0)
    row = np.round(y / 1.9)
    shifted = x / 2.2 + 0.5 * (row % 2) + rng.uniform()
    distance = hypot((shifted - np.round(shifted)) * 2.2, y - row * 1.9)
    dimple = 0.3 * np.sqrt(np.maximum(1 - (distance / 0.85) ** 2, 0))
    return where_solid((6 - np.sqrt(square) + dimple).astype(np.float32), square > 1)


def can_rim(x, y, rng):
    """Return an arc of a tin's rolled rim, its inner wall lower than its outer one."""
    off = hypot(x, y + 26) - 26
    bead_height = 0.9 - np.sqrt(np.maximum(0.81 - off**2, 0))
    wall = np.where(off < 0, 1.5, 4.0) * np.maximum(np.abs(off) - 0.85, 0)
    seam = 0.06 * np.exp(-(((x - rng.uniform(-3, 3)) / 0.4) ** 2))
    return (bead_height + wall - seam).astype(np.float32)


def corner(x, y, rng):
    """Return a box's corner pointing at the gel, its three edges unevenly rounded."""
    height = np.full_like(x, -1e3)
    angles = np.radians([90, 215, 325]) + rng.uniform(-0.15, 0.15, 3)
    slopes = rng.uniform(0.45, 0.75, 3)
    for angle, slope in zip(angles, slopes, strict=True):
        face = slope * (np.cos(angle) * x + np.sin(angle) * y)
        gap = np.maximum(0.15 - np.abs(height - face), 0)
        height = np.maximum(height, face) + gap**2 / 0.6
    return height.astype(np.float32)


def cable(x, y, rng):
    """Return a flat twin cable: two cores under one jacket, with moulded cross ribs at one end."""
    bend = y - rng.uniform(-0.015, 0.015) * x * x
    core = np.abs(np.abs(bend) - 1.4)
    jacket = 1.6 - np.sqrt(np.maximum(1.6**2 - core**2, 0))
    relief = 0.25 * (np.sin(2 * np.pi * x / 1.9) > 0.3) * (x > rng.uniform(-2, 3))
    solid = np.abs(bend) < 2.95
    return where_solid((jacket - relief + 0.004 * x * x).astype(np.float32), solid)


def table_edge(x, y, rng):
    """Return a long edge between a level top and a steep side, with a rounded lip."""
    lip = rng.uniform(0.3, 1.2)
    top = rng.uniform(0.03, 0.12) * np.maximum(-y, 0)
    past = np.maximum(y + lip, 0)
    fall = np.where(
        past < lip, lip - np.sqrt(np.maximum(lip**2 - past**2, 0)), lip + 8 * (past - lip)
    )
    return (top + fall + 0.002 * x * x).astype(np.float32)


EVERYDAY: dict[str, Indenter] = {
    formula.__name__: Indenter(formula)
    for formula in (bottle_cap, key, hex_nut, screw_head, coin, bead, pen_clip)
    + (textured_ball, can_rim, corner, cable, table_edge)
}

_TRAINING = SOLIDS | SURFACES | FACES

TRAINING_OBJECTS: tuple[str, ...] = tuple(_TRAINING)
"""Names a model may be trained on."""

EVERYDAY_OBJECTS: tuple[str, ...] = tuple(EVERYDAY)
"""Names kept for evaluation."""

INDENTERS: dict[str, Indenter] = _TRAINING | EVERYDAY


def require_shape(name: str) -> None:
    """Refuse, with a `UsageError`, a name that no body has."""
    if name not in INDENTERS:
        raise UsageError(f"There is no shape '{name[:40]}'; {choice_of(name, sorted(INDENTERS))}")
