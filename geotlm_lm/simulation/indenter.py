"""What a body is: a height formula and two facts about it; knows no concrete shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.simulation.raster import OUTSIDE_MM

HeightMap = NDArray[np.float32]
HeightFormula = Callable[[HeightMap, HeightMap, np.random.Generator], HeightMap]


@dataclass(frozen=True)
class Indenter:
    """One kind of body.

    Args:
        height: (x_mm, y_mm, rng) -> height of the underside in mm, any lowest value, `OUTSIDE_MM`
            or more where there is no body; the generator draws what varies within the kind.
        is_axisymmetric: Its bare form looks the same after any turn about its middle, so that only
            texture or an eccentric axis shows a rotation.
        is_extended: It goes on beyond the sampled square.
    """

    height: HeightFormula
    is_axisymmetric: bool = False
    is_extended: bool = False


def extrude(inside_mm: HeightMap, fillet_mm: float, wall_slope: float = 20.0) -> HeightMap:
    """Return the flat-faced body over an outline, its rim rounded.

    Args:
        inside_mm: Distance inside the outline, negative outside.
        fillet_mm: Radius of the rim.
        wall_slope: Rise of the wall outside the outline, mm per mm; steep, yet finite, so that
            interpolation never sees a jump.
    """
    toward_rim = np.clip(fillet_mm - inside_mm, 0, fillet_mm)
    rim = fillet_mm - np.sqrt(np.maximum(fillet_mm**2 - toward_rim**2, 0))
    return rim + np.where(inside_mm < 0, -inside_mm * wall_slope, 0).astype(np.float32)


def turned(x: HeightMap, y: HeightMap, angle_rad: float) -> tuple[HeightMap, HeightMap]:
    """Return the coordinates in a frame turned by `angle_rad`."""
    cos, sin = np.float32(np.cos(angle_rad)), np.float32(np.sin(angle_rad))
    return cos * x + sin * y, cos * y - sin * x


def where_solid(height_mm: HeightMap, is_solid: NDArray[np.bool_]) -> HeightMap:
    """Return the height inside a body and `OUTSIDE_MM` elsewhere."""
    return np.where(is_solid, height_mm, np.float32(OUTSIDE_MM))


def hypot(x: HeightMap, y: HeightMap) -> HeightMap:
    """Return the length of (x, y).

    A tenth of the cost of numpy's, which guards against squares too large for the type: no length
    here is.
    """
    return np.sqrt(x * x + y * y)


def bowl(x: HeightMap, y: HeightMap, radius_mm: float) -> HeightMap:
    """Return the height of a sphere-like underside, r^2 / 2R, that never ends."""
    return (x * x + y * y) * np.float32(0.5 / radius_mm)


def rounded_back(
    x: HeightMap, y: HeightMap, rng: np.random.Generator, flattest_mm: float
) -> HeightMap:
    """Return what a rough surface sits on: a ball, an egg or a roller of random radius."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    across = np.exp(rng.uniform(np.log(6), np.log(flattest_mm)))
    along = across * rng.choice([1.0, 2.0, 8.0], p=[0.5, 0.3, 0.2])
    return (u * u) * np.float32(0.5 / along) + (v * v) * np.float32(0.5 / across)


def extended(formula: HeightFormula) -> Indenter:
    """Return the body of a formula that goes on beyond the sampled square."""
    return Indenter(formula, is_extended=True)
