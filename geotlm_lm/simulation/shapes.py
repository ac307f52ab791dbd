"""What bodies are made of: height formulas, outlines, marks and random fields; no concrete body.

A formula is (x, y, rng) -> height of the underside: coordinates and heights are float32 arrays of
one shape in mm, x right and y down; the generator draws what varies within the kind. Any value may
be the lowest; `OUTSIDE_MM` or more means that there is no body.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UsageError, first_line
from geotlm_lm.core.image_size import declared_size, is_cut_off

RASTER_SIDE = 400
"""Samples per side of an object's height map."""

RASTER_MM = 25.6
"""Side of the height map in mm; the size of GelSight Mini's pad, finer than its camera's pixels."""

PX_PER_MM = RASTER_SIDE / RASTER_MM

OUTSIDE_MM = 1000.0
"""Height standing for 'no object here': far above any depth, finite so that it interpolates."""

WALL_SLOPE = 20.0
"""Rise of a wall, mm per mm: steep, yet finite, so that interpolation sees no jump."""

HeightMap = NDArray[np.float32]
HeightFormula = Callable[[HeightMap, HeightMap, np.random.Generator], HeightMap]


@dataclass(frozen=True)
class Indenter:
    """One kind of body."""

    height: HeightFormula
    is_axisymmetric: bool = False  # only texture or an eccentric axis shows a turn of its bare form
    is_extended: bool = False  # it goes on beyond the sampled square


@cache
def object_grid() -> tuple[HeightMap, HeightMap]:
    """Return x and y of every sample in mm, (RASTER_SIDE, RASTER_SIDE), read-only."""
    axis = ((np.arange(RASTER_SIDE) + 0.5) / RASTER_SIDE - 0.5) * RASTER_MM
    x, y = np.meshgrid(axis.astype(np.float32), axis.astype(np.float32))
    x.setflags(write=False)
    y.setflags(write=False)
    return x, y


def extrude(inside_mm, fillet_mm: float):
    """Return the flat-faced body over an outline (distance inside it), its rim rounded."""
    toward_rim = np.clip(fillet_mm - inside_mm, 0, fillet_mm)
    rim = fillet_mm - np.sqrt(np.maximum(fillet_mm**2 - toward_rim**2, 0))
    return rim + np.where(inside_mm < 0, -inside_mm * WALL_SLOPE, 0).astype(np.float32)


def turned(x, y, angle_rad: float) -> tuple[HeightMap, HeightMap]:
    """Return the coordinates in a frame turned by `angle_rad`."""
    cos, sin = np.float32(np.cos(angle_rad)), np.float32(np.sin(angle_rad))
    return cos * x + sin * y, cos * y - sin * x


def where_solid(height_mm, is_solid):
    """Return the height inside a body and `OUTSIDE_MM` elsewhere."""
    return np.where(is_solid, height_mm, np.float32(OUTSIDE_MM))


def hypot(x, y):
    """Return the length of (x, y).

    A tenth of the cost of numpy's, which guards against squares too large for the type: no length
    here is.
    """
    return np.sqrt(x * x + y * y)


def bowl(x, y, radius_mm: float):
    """Return the height of a sphere-like underside, r^2 / 2R, that never ends."""
    return (x * x + y * y) * np.float32(0.5 / radius_mm)


def rounded_back(x, y, rng, flattest_mm: float):
    """Return what a rough surface sits on: a ball, an egg or a roller of random radius."""
    u, v = turned(x, y, rng.uniform(0, np.pi))
    across = np.exp(rng.uniform(np.log(6), np.log(flattest_mm)))
    along = across * rng.choice([1.0, 2.0, 8.0], p=[0.5, 0.3, 0.2])
    return (u * u) * np.float32(0.5 / along) + (v * v) * np.float32(0.5 / across)


def polar(x, y) -> tuple[HeightMap, HeightMap]:
    """Return the angle, -pi to pi from x towards y, and the distance from the origin."""
    return np.arctan2(y, x), hypot(x, y)


def to_nearest(angle, count: int | HeightMap):
    """Return the angle from the nearest of `count` even directions, the first along x."""
    step = np.float32(2 * np.pi) / count
    return angle - np.round(angle / step) * step


def within(distance_mm, radius_mm: float, ramp_mm: float):
    """Return 1 inside `radius_mm`, 0 outside, with a ramp between."""
    return np.clip((radius_mm - distance_mm) / np.float32(ramp_mm), 0, 1)


def strokes(x, y, rng, *, count: int, reach_mm: float):
    """Return 1 along a few random straight strokes, as of stamped letters, and 0 elsewhere."""
    drawn, px_per_mm, subpixel_bits = np.zeros(x.shape, np.uint8), 1 / float(x[0, 1] - x[0, 0]), 4
    for _ in range(count):
        middle, angle = rng.uniform(-reach_mm, reach_mm, 2), rng.uniform(0, np.pi)
        half = rng.uniform(0.5, 2.0) * np.array([np.cos(angle), np.sin(angle)])
        ends = (np.stack([middle - half, middle + half]) - (x[0, 0], y[0, 0])) * px_per_mm
        first, last = np.round(ends * 2**subpixel_bits).astype(int).tolist()
        width = max(round(rng.uniform(0.5, 1.0) * px_per_mm), 1)
        cv2.line(drawn, first, last, 255, width, cv2.LINE_AA, subpixel_bits)
    return drawn.astype(np.float32) / 255


def picture(x, rng, *, scale_mm: float):
    """Return a smooth random relief of unit deviation, as of a worn portrait."""
    thinned = slice(None, None, RASTER_SIDE // len(x))
    return smooth_field(rng, scale_mm)[thinned, thinned]


def smooth_field(rng: np.random.Generator, scale_mm: float) -> HeightMap:
    """Return a random field on the raster, mean 0 and deviation 1, correlated over `scale_mm`.

    Coarse normal numbers enlarged by cubic interpolation: a tenth of the cost of filtering.
    """
    apart_px = scale_mm * PX_PER_MM
    coarse = int(np.ceil(RASTER_SIDE / max(apart_px, 1.0))) + 3
    numbers = rng.standard_normal((coarse, coarse), dtype=np.float32)
    enlarged = round(coarse * apart_px) if apart_px > 1 else coarse
    field = cv2.resize(numbers, (enlarged, enlarged), interpolation=cv2.INTER_CUBIC)
    row, column = rng.integers(0, max(enlarged - RASTER_SIDE, 0) + 1, 2)
    field = field[row : row + RASTER_SIDE, column : column + RASTER_SIDE]
    # Every fourth sample gives the moments of a field this smooth, at a tenth of the cost.
    some = field[::4, ::4]
    mean, size = float(some.mean()), max(float(some.std()), 1e-6)
    return cv2.addWeighted(field, 1 / size, field, 0, -mean / size)


FEWEST_SAMPLES = 8
"""Samples per side below which a map shows no shape."""

MM_PER_PX = (0.001, 2.0)
"""Pixel sizes that make sense: below the light's wavelength, and a tenth of the pad."""

TALLEST_MM = 20.0
"""Relief beyond which a map is most likely in another unit."""

MOST_SAMPLES = 8192
"""Of a side of a .png: two micrometres a sample on the pad, which no camera resolves."""


def read_height_map(path: Path, mm_per_px: float, *, relief_mm: float = 1.0) -> Indenter:
    """Read a user's own body from a file; bad sizes and files are `UsageError`s.

    The file is a .npy of heights in mm, shape (rows, columns), NaN where there is no object; or a
    grey .png of 8 or 16 bit, black lowest and white `relief_mm` above.
    """
    height = _read_npy(path) if path.suffix.lower() == ".npy" else _read_png(path, relief_mm)
    return height_map_indenter(height, mm_per_px, name=str(path))


def height_map_indenter(
    height_mm: NDArray[np.floating], mm_per_px: float, *, name: str = "height map"
) -> Indenter:
    """Return the body of a height map, seen as the camera sees it: columns right, rows down.

    Higher is nearer to the gel; NaN where no object is. Errors call it `name`.
    """
    _check_map(height_mm, mm_per_px, name)
    solid = np.isfinite(height_mm)
    below = np.where(solid, float(height_mm[solid].max()) - height_mm, np.nan).astype(np.float32)
    # Steps of the map's border and holes become walls, like those of the built-in outlines.
    hollow = (~solid).astype(np.uint8)
    away = cv2.distanceTransform(hollow, cv2.DIST_L2, 5) if hollow.any() else 0
    floor = np.float32(np.nanmax(below))
    below = np.where(solid, below, floor + np.float32(WALL_SLOPE * mm_per_px) * away)
    rows, columns = below.shape

    def height(x, y, rng):
        column = x / np.float32(mm_per_px) + np.float32((columns - 1) / 2)
        row = y / np.float32(mm_per_px) + np.float32((rows - 1) / 2)
        inside = cv2.remap(
            below.astype(np.float32), column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        beyond_x = np.maximum(np.abs(x) - columns * mm_per_px / 2, 0)
        beyond_y = np.maximum(np.abs(y) - rows * mm_per_px / 2, 0)
        wall = np.float32(WALL_SLOPE) * np.hypot(beyond_x, beyond_y)
        return np.minimum(inside + wall, np.float32(OUTSIDE_MM))

    return Indenter(height)


def _check_map(height_mm: NDArray[np.floating], mm_per_px: float, name: str) -> None:
    low, high = MM_PER_PX
    if not low <= mm_per_px <= high:
        raise UsageError(
            f"{mm_per_px:g} mm per pixel, expected {low:g} to {high:g}; check the unit."
        )
    if height_mm.ndim != 2 or min(height_mm.shape) < FEWEST_SAMPLES:
        raise UsageError(
            f"{name}: shape {height_mm.shape}, expected (rows, columns) with at least "
            f"{FEWEST_SAMPLES} each; save one height per sample."
        )
    if not np.issubdtype(height_mm.dtype, np.floating) or np.isinf(height_mm).any():
        raise UsageError(f"{name}: expected heights in mm as finite floats, NaN where nothing is.")
    if not np.isfinite(height_mm).any():
        raise UsageError(f"{name}: every height is NaN; there is no object in it.")
    size = max(height_mm.shape) * mm_per_px
    if size > RASTER_MM:
        raise UsageError(
            f"{name}: {size:.1f} mm at {mm_per_px:g} mm per pixel, expected at most the pad's "
            f"{RASTER_MM:g} mm; crop it, or check the pixel size."
        )
    relief = float(np.nanmax(height_mm) - np.nanmin(height_mm))
    if relief > TALLEST_MM:
        raise UsageError(
            f"{name}: heights span {relief:.0f} mm, expected at most {TALLEST_MM:g}; are they in "
            f"micrometres?"
        )


def _read_npy(path: Path) -> NDArray[np.floating]:
    try:
        # Mapped first: a header may declare any size, a mapping only what the file holds.
        return np.array(np.lib.format.open_memmap(path, mode="r"))
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror}); check the name.") from error
    except Exception as error:
        # A damaged header fails in a dozen ways: ValueError, TokenError, OverflowError, ...
        raise UsageError(
            f"{path}: cannot be read as .npy ({first_line(error)}); save it with np.save."
        ) from error


def _read_png(path: Path, relief_mm: float) -> NDArray[np.floating]:
    try:
        stored = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: cannot be opened ({error.strerror}); check the name.") from error
    rows, columns = declared_size(stored) or (0, 0)
    if max(rows, columns) > MOST_SAMPLES:
        raise UsageError(
            f"{path}: is {columns}x{rows} samples, expected at most {MOST_SAMPLES} a side; save a "
            f"smaller one."
        )
    if is_cut_off(stored):
        raise UsageError(f"{path}: is cut off; copy or save it again.")
    try:
        image = cv2.imdecode(np.frombuffer(stored, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:  # nothing in it, or sizes that cannot be
        image = None
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise UsageError(
            f"{path}: is no .npy and no 8 or 16 bit .png; save the map as one of them."
        )
    if image.ndim != 2:
        raise UsageError(f"{path}: has colours, expected one grey channel; save it as grey.")
    if not 0 < relief_mm <= TALLEST_MM:
        raise UsageError(f"a relief of {relief_mm:g} mm, expected above 0 to {TALLEST_MM:g}.")
    return image * (relief_mm / np.iinfo(image.dtype).max)
