"""Kinds of gel: how each is lit, what is printed on it, how its pad is; which are for training.

Only the GelSight Mini is measured. The other lamps are drawn after what is published of the sensors
they are named after, as far as this renderer's optics reach; their numbers are assumed, between the
Mini's weakest and strongest light where nothing else is noted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from geotlm_lm.simulation.scene import GELSIGHT_MINI, Lamps, Markers, Pattern, Three


class Print(StrEnum):
    """What is printed on a gel, or on the lens before it."""

    NONE = "nothing"
    DOTS = "dots on a square grid"
    WORN_DOTS = "a worn grid of dots"
    RANDOM_DOTS = "dots anywhere"
    STATIC_DOTS = "dots that stand still"
    BLOTCHES = "blotches"
    MESH = "a mesh of lines"


@dataclass(frozen=True)
class GelKind:
    """What a sensor's gel looks like."""

    name: str
    share: float  # of training's clips; 0 keeps the kind out of training
    lamps: Lamps = GELSIGHT_MINI
    printed: Print = Print.NONE
    flat_share: float = 0.0  # share of pads without a dome; a Mini's has one
    most_px: float | None = None  # longest path of a motion; None for any


def _lit_from(
    sides_deg: Three, *, slope: float, ambient: Three, lobe: Three, width: float, **others
) -> Lamps:
    """Return lamps that stand in these directions (0 right, 90 down), each in its own colour.

    A slope that faces a lamp brightens by `slope` per unit; the untouched gel has the grey level
    `ambient`, and `lobe` more at the lamp, over a Gaussian of `width` half views.
    """
    angles = np.radians(sides_deg)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    x, y = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5))
    idle = tuple(
        tuple(map(tuple, (base + peak * np.exp(-distance / (2 * width**2))).tolist()))
        for (across, down), base, peak in zip(ways, ambient, lobe, strict=True)
        for distance in [(x - across) ** 2 + (y - down) ** 2]
    )
    rows = tuple((slope * ways).tolist())
    return Lamps(tuple(map(tuple, rows)), idle, usual_turn_deg=(0.0, 0.0, 0.0), **others)


def _white_all_round(level: float, at_rim: float, **others) -> Lamps:
    """Return white light from all around: grey levels in the middle, and `at_rim` more there."""
    x, y = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5))
    plane = tuple(map(tuple, (level + at_rim * (x**2 + y**2) / 2).tolist()))
    # A stray light's direction is hardly seen: a quarter of the Mini's.
    lamps = {"usual_turn_deg": (0.0,) * 3, "common_light": 0.035, "is_white": True} | others
    return Lamps(((0.0, 0.0),) * 3, (plane,) * 3, **lamps)


THREE_LAMPS = _lit_from(
    (90.0, 210.0, 330.0), slope=0.7, ambient=(55, 60, 75), lobe=(150, 120, 140), width=0.65
)
"""Like a DIGIT's: three coloured lamps 120 degrees apart, bright beside the rim of the idle gel."""

CORNER_LAMPS = _lit_from(
    (160.0, 270.0, 20.0), slope=0.45, ambient=(85, 70, 110), lobe=(150, 150, 90), width=0.5
)
"""Like a GelSlim's or a DuraGel's: flat light from the rim, whose lamps are seen as bright spots;
grey levels after recordings of a GelSlim 4.0, whose imprints are weaker than a Mini's."""

WHITE_SIDE = _lit_from(
    (0.0,) * 3, slope=0.7, ambient=(80,) * 3, lobe=(90,) * 3, width=1.1, is_white=True,
    depth_gain=(0.06,) * 3,
)  # fmt: skip
"""White light from one side."""

WHITE_RING = _white_all_round(105, 45, steep_darkening=(0.15, 0.4), depth_gain=(-0.12,) * 3)
"""A white ring: no slope faces it more than another; flanks and depths are darker."""

DARK = _white_all_round(95, 25, steep_darkening=(0.0, 0.1), depth_gain=(-0.3,) * 3)
"""Like a 9DTact's: the deeper the darker, whatever the slope."""

CROSSED_LAMPS = _lit_from(
    (180.0, 0.0, 270.0), slope=0.6, ambient=(100, 95, 90), lobe=(70, 60, 60), width=0.9
)
"""Red, green and blue from left, right and above: another sensor's, drawn after ToucHD-Sim."""

SMALL_PX = 2.0
"""Longest path of a motion there: such recordings hardly move from frame to frame."""

_KINDS = (
    GelKind("mini", 0.33),
    GelKind("mini, dots", 0.09, printed=Print.DOTS),
    GelKind("mini, worn dots", 0.07, printed=Print.WORN_DOTS),
    GelKind("mini, blotches", 0.05, printed=Print.BLOTCHES),
    GelKind("three lamps", 0.14, THREE_LAMPS, flat_share=0.5),
    GelKind("three lamps, dots", 0.05, THREE_LAMPS, Print.DOTS, flat_share=0.5),
    GelKind("corner lamps, worn dots", 0.05, CORNER_LAMPS, Print.WORN_DOTS, flat_share=0.5),
    GelKind("white side", 0.06, WHITE_SIDE, flat_share=0.5),
    GelKind("white side, mesh", 0.05, WHITE_SIDE, Print.MESH, flat_share=0.5),
    GelKind("white ring", 0.06, WHITE_RING, flat_share=0.5),
    GelKind("white ring, dots", 0.05, WHITE_RING, Print.DOTS, flat_share=0.5),
    GelKind("mini, random dots", 0.0, printed=Print.RANDOM_DOTS),
    GelKind("dark gel", 0.0, DARK, flat_share=1.0),
    GelKind("static dots", 0.0, CROSSED_LAMPS, Print.STATIC_DOTS, flat_share=1.0, most_px=SMALL_PX),
)

GELS: Mapping[str, GelKind] = {kind.name: kind for kind in _KINDS}

TRAINING_GELS = {kind.name: kind.share for kind in _KINDS if kind.share > 0}
"""Kinds in training, by their share: about half with a Mini's lamps, 41 % printed on; assumed."""

HELD_OUT_GELS = {kind.name: 1.0 for kind in _KINDS if kind.share == 0}
"""Kinds that no training sees, each as often."""

MARKER_SPACING_MM = (1.8, 2.9)
MARKER_DIAMETER_SHARE = (0.3, 0.45)
MARKER_DARKNESS = (0.45, 0.8)
"""Dots: distance, width relative to it, darkness; about five recordings of marked GelSight Minis
(1.9 to 2.8 mm, 0.36 to 0.43, 0.56 to 0.62)."""

WORN_JITTER, WORN_MISSING, WORN_UNEVENNESS = (0.02, 0.12), (0.05, 0.4), (0.2, 0.8)
"""Of a worn grid: how far dots lie off it, how many are missing, how pale they are. Assumed."""

RANDOM_SPACING_MM = (1.0, 2.2)
"""One dot, anywhere, per square of this side. Assumed: denser than grids, as for tracking."""

MESH_PITCH_MM, MESH_SHARE = (1.2, 3.0), (0.12, 0.3)
BLOTCH_MM, BLOTCH_SHARE = (0.25, 0.8), (0.25, 0.5)
PATTERN_DARKNESS = (0.3, 0.7)
"""Pitch and width of lines, size and share of blotches, and their darkness. Assumed."""


def random_kind(rng: np.random.Generator, shares: Mapping[str, float]) -> GelKind:
    """Return one of the named kinds, each as often as its share of their sum says."""
    weights = np.array(list(shares.values()))
    return GELS[list(shares)[rng.choice(len(weights), p=weights / weights.sum())]]


def random_markers(rng: np.random.Generator, **others) -> Markers:
    """Return a grid of dots like those of gels on sale."""
    spacing = rng.uniform(*MARKER_SPACING_MM)
    values = {
        "spacing_mm": spacing,
        "diameter_mm": spacing * rng.uniform(*MARKER_DIAMETER_SHARE),
        "darkness": rng.uniform(*MARKER_DARKNESS),
        "x_mm": rng.uniform(-0.5, 0.5) * spacing,
        "y_mm": rng.uniform(-0.5, 0.5) * spacing,
    }
    return Markers(**values | others)


def random_print(rng: np.random.Generator, printed: Print) -> Markers | Pattern | None:
    """Return a print of a kind, its size, place and wear drawn."""
    seed = int(rng.integers(2**31))
    if printed is Print.NONE:
        return None
    if printed in (Print.MESH, Print.BLOTCHES):
        is_mesh = printed is Print.MESH
        pitch = rng.uniform(*(MESH_PITCH_MM if is_mesh else BLOTCH_MM))
        return Pattern(
            "mesh" if is_mesh else "blotches",
            pitch_mm=pitch,
            share=rng.uniform(*(MESH_SHARE if is_mesh else BLOTCH_SHARE)),
            darkness=rng.uniform(*PATTERN_DARKNESS),
            x_mm=rng.uniform(-0.5, 0.5) * pitch,
            y_mm=rng.uniform(-0.5, 0.5) * pitch,
            seed=seed,
        )
    if printed is Print.WORN_DOTS:
        ranges = {"jitter": WORN_JITTER, "missing": WORN_MISSING, "unevenness": WORN_UNEVENNESS}
        worn = {name: rng.uniform(*span) for name, span in ranges.items()}
        return random_markers(rng, seed=seed, **worn)
    if printed is Print.RANDOM_DOTS:
        spacing = rng.uniform(*RANDOM_SPACING_MM)
        return random_markers(
            rng,
            seed=seed,
            spacing_mm=spacing,
            diameter_mm=spacing * rng.uniform(*MARKER_DIAMETER_SHARE),
            jitter=0.5,
        )
    return random_markers(rng, is_carried=printed is not Print.STATIC_DOTS)
