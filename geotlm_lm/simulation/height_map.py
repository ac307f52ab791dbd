"""A user's own object: a height map from a file becomes an indenter like any other.

The map is seen as the camera sees the object: columns run right, rows run down, and the highest
point touches the gel first.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.image_size import declared_size, is_cut_off
from geotlm_lm.simulation.indenter import HeightMap, Indenter
from geotlm_lm.simulation.raster import OUTSIDE_MM, RASTER_MM

FEWEST_SAMPLES = 8
"""Samples per side below which a map shows no shape."""

MM_PER_PX = (0.001, 2.0)
"""Pixel sizes that make sense: below the light's wavelength, and a tenth of the pad."""

TALLEST_MM = 20.0
"""Relief beyond which a map is most likely in another unit."""

MOST_SAMPLES = 8192
"""Of a side of a .png: two micrometres a sample on the pad, which no camera resolves."""

WALL_SLOPE = 20.0
"""Rise around the map's edge, mm per mm: steep, yet finite, so that interpolation sees no jump."""


def read_height_map(path: Path, mm_per_px: float, *, relief_mm: float = 1.0) -> Indenter:
    """Read a body from a file.

    Args:
        path: A .npy of heights in mm, shape (rows, columns), NaN where there is no object; or a
            grey .png of 8 or 16 bit, black lowest and white `relief_mm` above.
        mm_per_px: Size of one sample.
        relief_mm: Height of white above black in a .png.

    Raises:
        UsageError: If the file is no such map, or sizes make no sense.
    """
    height = _read_npy(path) if path.suffix.lower() == ".npy" else _read_png(path, relief_mm)
    return height_map_indenter(height, mm_per_px, name=str(path))


def height_map_indenter(
    height_mm: NDArray[np.floating], mm_per_px: float, *, name: str = "height map"
) -> Indenter:
    """Return the body of a height map.

    Args:
        height_mm: Shape (rows, columns), higher is nearer to the gel; NaN where no object is.
        mm_per_px: Size of one sample.
        name: What errors call it.

    Raises:
        UsageError: If it is no two-dimensional map of finite heights, or sizes make no sense.
    """
    _check(height_mm, mm_per_px, name)
    solid = np.isfinite(height_mm)
    highest = float(height_mm[solid].max())
    below = np.where(solid, highest - height_mm, np.nan).astype(np.float32)
    # Steps of the map's border and holes become walls, like those of the built-in outlines.
    away = (
        cv2.distanceTransform((~solid).astype(np.uint8), cv2.DIST_L2, 5) if not solid.all() else 0
    )
    floor = np.float32(np.nanmax(below))
    below = np.where(solid, below, floor + np.float32(WALL_SLOPE * mm_per_px) * away)
    rows, columns = below.shape

    def height(x: HeightMap, y: HeightMap, rng: np.random.Generator) -> HeightMap:
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


def _check(height_mm: NDArray[np.floating], mm_per_px: float, name: str) -> None:
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
        said = (str(error).splitlines() or [type(error).__name__])[0]
        raise UsageError(
            f"{path}: cannot be read as .npy ({said}); save it with np.save."
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
