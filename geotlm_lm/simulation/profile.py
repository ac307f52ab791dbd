"""The object's underside as a sampled height map, placed by a pose; knows no gel and no light.

A profile is f(x, y) >= 0 in mm above the object's lowest point, sampled on a square raster in the
object's own frame, lean and texture included. Outside a finite object it is about `OUTSIDE_MM`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import cv2
import numpy as np

from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.scene import Body
from geotlm_lm.simulation.shapes import (
    OUTSIDE_MM,
    RASTER_MM,
    RASTER_SIDE,
    HeightMap,
    object_grid,
    smooth_field,
)

Pose = tuple[float, float, float]
"""x and y of the object in mm, its turn in radians."""

REACH_MM = 0.4
"""Height band whose centroid counts as the middle of the contact; a typical pressing depth."""

FINE_PER_CELL = 5
"""Samples per contact cell and axis; odd, so that one of them is the cell's centre."""

SMOOTH_MM = 0.005
"""Error of interpolation between contact cells below which a body counts as smooth: a quarter of
the gap that counts as contact."""


class Window(NamedTuple):
    """A rectangle of an image, ends excluded: rows first to last, columns likewise."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """The rectangle as an index, rows first."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


@dataclass(frozen=True, eq=False)
class Profile:
    """A body ready to be placed."""

    height_mm: HeightMap  # (RASTER_SIDE, RASTER_SIDE), the leaning body above its lowest point
    middle_mm: tuple[float, float]  # what a pose's (x, y) places, in the object's frame
    is_extended: bool  # it goes on beyond the raster (mirrored there) instead of ending
    # What was asked before: bounds by reach, smoothness by spacing and reach.
    _known: dict[Any, Any] = field(default_factory=dict)

    def sample(
        self, pose: Pose, mm_per_px: tuple[float, float], side: int, window: Window | None = None
    ) -> HeightMap:
        """Return f on a `window`, or all, of a square image about the middle of the view."""
        window = window or Window(0, side, 0, side)
        x_mm, y_mm, angle = pose
        cos, sin = math.cos(angle), math.sin(angle)
        column = (window.left - (side - 1) / 2) * mm_per_px[0] - x_mm
        row = (window.top - (side - 1) / 2) * mm_per_px[1] - y_mm
        # Gel frame -> object frame is the inverse turn, then the offset of the object's middle.
        origin_x = cos * column + sin * row + self.middle_mm[0]
        origin_y = -sin * column + cos * row + self.middle_mm[1]
        raster = RASTER_MM / RASTER_SIDE
        matrix = np.array(
            [
                [cos * mm_per_px[0], sin * mm_per_px[1], origin_x + RASTER_MM / 2 - raster / 2],
                [-sin * mm_per_px[0], cos * mm_per_px[1], origin_y + RASTER_MM / 2 - raster / 2],
            ]
        )
        return cv2.warpAffine(
            self.height_mm,
            matrix / raster,
            (window.right - window.left, window.bottom - window.top),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REFLECT_101 if self.is_extended else cv2.BORDER_CONSTANT,
            borderValue=OUTSIDE_MM,
        )

    def window(
        self, pose: Pose, mm_per_px: tuple[float, float], side: int, reach_mm: float
    ) -> Window:
        """Return a part of the image, perhaps empty, outside of which f exceeds `reach_mm`."""
        # Plain floats: eight calls a clip on arrays of four cost more than the pixels they save.
        low, high = self._bounds_mm(reach_mm)
        x_mm, y_mm, angle = pose
        cos, sin = math.cos(angle), math.sin(angle)
        if self.is_extended:
            # Its mirror images begin a raster's side away from where it ends.
            far_x, far_y = side / 2 * mm_per_px[0] + abs(x_mm), side / 2 * mm_per_px[1] + abs(y_mm)
            along = abs(cos) * far_x + abs(sin) * far_y + abs(self.middle_mm[0])
            across = abs(sin) * far_x + abs(cos) * far_y + abs(self.middle_mm[1])
            starts = [RASTER_MM - max(-low[axis], high[axis]) for axis in (0, 1)]
            if along > starts[0] or across > starts[1]:
                return Window(0, side, 0, side)
        columns, rows = [], []
        for x in (low[0] - self.middle_mm[0], high[0] - self.middle_mm[0]):
            for y in (low[1] - self.middle_mm[1], high[1] - self.middle_mm[1]):
                columns.append((cos * x - sin * y + x_mm) / mm_per_px[0] + (side - 1) / 2)
                rows.append((sin * x + cos * y + y_mm) / mm_per_px[1] + (side - 1) / 2)
        return Window(*_whole(rows, side), *_whole(columns, side))

    def _bounds_mm(self, reach_mm: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return least and greatest (x, y) of what lies lower than `reach_mm`, object frame."""
        if reach_mm not in self._known:
            low = (self.height_mm < np.float32(reach_mm)).view(np.uint8)
            left, top, width, height = cv2.boundingRect(low)
            raster, half = RASTER_MM / RASTER_SIDE, RASTER_MM / 2
            # One sample more on every side: between samples the body is as low as the lower one.
            self._known[reach_mm] = (
                ((left - 0.5) * raster - half, (top - 0.5) * raster - half),
                ((left + width + 0.5) * raster - half, (top + height + 0.5) * raster - half),
            )
        return self._known[reach_mm]

    def on_cells(
        self,
        pose: Pose,
        box_mm: float,
        side: int,
        reach_mm: float = np.inf,
        *,
        is_smooth: bool = False,
    ) -> HeightMap:
        """Return f on the contact grid; a feature narrower than a cell keeps its lowest point.

        What lies higher than `reach_mm` may come back as `OUTSIDE_MM`. Of a smooth body, which has
        no feature narrower than a cell, the cells' centres say all.
        """
        cell = box_mm / side
        window = self.window(pose, (cell, cell), side, reach_mm)
        cells = np.full((side, side), OUTSIDE_MM, np.float32)
        if window.bottom == window.top or window.right == window.left:
            return cells
        if is_smooth:
            cells[window.slices] = self.sample(pose, (cell, cell), side, window)
        else:
            fine = Window(*(FINE_PER_CELL * edge for edge in window))
            size = (cell / FINE_PER_CELL,) * 2
            height = self.sample(pose, size, side * FINE_PER_CELL, fine)
            cells[window.slices] = pool_to_cells(height, FINE_PER_CELL)
        return cells

    def is_smooth(self, spacing_mm: float, reach_mm: float) -> bool:
        """Tell whether cubic interpolation over `spacing_mm` gives the body below `reach_mm`."""
        key = (spacing_mm, reach_mm)
        if key not in self._known:
            self._known[key] = self._check_smooth(spacing_mm, reach_mm)
        return self._known[key]

    def _check_smooth(self, spacing_mm: float, reach_mm: float) -> bool:
        low, high = self._bounds_mm(reach_mm)
        half = int(np.ceil(spacing_mm / (RASTER_MM / RASTER_SIDE) / 2))
        first, last = (
            (np.array(corner) + RASTER_MM / 2) * RASTER_SIDE / RASTER_MM for corner in (low, high)
        )
        start, end = first.astype(int) - 3 * half, last.astype(int) + 3 * half + 1
        if start.min() < 0 or end.max() > RASTER_SIDE:
            return False
        body = self.height_mm[start[1] : end[1], start[0] : end[0]]
        # The lines through the middle first: hardly a textured body gets farther.
        middle = [size // 2 for size in body.shape]
        lines = body[middle[0], None], body[:, middle[1], None].T
        return all(_is_smooth_along(rows, half, reach_mm) for rows in (*lines, body, body.T))

    def depth_for_area(self, area_mm2: float) -> float:
        """Return the depth at which `area_mm2` of the object lies below it."""
        values = self.height_mm[::4, ::4].ravel()
        rank = min(int(area_mm2 / RASTER_MM**2 * values.size), values.size - 1)
        return float(np.partition(values, rank)[rank])


def _whole(edges: list[float], side: int) -> tuple[int, int]:
    """Return the whole numbers around all `edges`, two more on each side, kept inside the image."""
    first, last = math.floor(min(edges)) - 2, math.ceil(max(edges)) + 3
    return min(max(first, 0), side), max(min(last, side), 0)


def _is_smooth_along(lines: HeightMap, half: int, reach_mm: float) -> bool:
    """Tell whether cubic interpolation over `2 * half` samples gives every low row of `lines`."""
    count = lines.shape[1] - 6 * half
    a, b, here, c, d = (lines[:, k * half : k * half + count] for k in (0, 2, 3, 4, 6))
    wrong = np.abs(here - (9 * (b + c) - (a + d)) / 16)
    return bool((wrong[here < reach_mm] < SMOOTH_MM).all())


def pool_to_cells(fine: HeightMap, per_cell: int) -> HeightMap:
    """Reduce fine samples to cells: the centre's height, or the lowest where a tip would vanish.

    Plain min-pooling would lower every slope by half a cell's rise and overstate the contact, so
    the minimum replaces the centre only where no neighbouring centre reaches as low.
    """
    return _pool_rows(_pool_rows(fine, per_cell).T, per_cell).T.copy()


def _pool_rows(fine: HeightMap, per_cell: int) -> HeightMap:
    centre = np.ascontiguousarray(fine[per_cell // 2 :: per_cell])
    lowest = centre.copy()
    for offset in range(per_cell):
        np.minimum(lowest, fine[offset::per_cell], out=lowest)
    around = centre.copy()
    np.minimum(around[1:], centre[:-1], out=around[1:])
    np.minimum(around[:-1], centre[1:], out=around[:-1])
    return np.where(lowest < around, lowest, centre)


@lru_cache(maxsize=32)
def build_profile(body: Body) -> Profile:
    """Return the profile of `body`; the same body always gives the same samples."""
    indenter = body.indenter or INDENTERS[body.name]
    rng = np.random.default_rng(body.variant)
    x, y = object_grid()
    scale = np.float32(body.size)
    height = np.ascontiguousarray(indenter.height(x / scale, y / scale, rng), dtype=np.float32)
    height = height * scale  # never in place: a shape may hand out what it keeps
    if body.texture_um > 0:
        texture = smooth_field(rng, body.texture_scale_mm)
        cv2.scaleAdd(texture, body.texture_um * 1e-3, height, dst=height)
    cv2.min(height, OUTSIDE_MM, dst=height)
    # A body that bends away everywhere only shows another spot when tilted; a finite one leans.
    if not indenter.is_extended:
        height += np.float32(body.tilt_x) * x[:1]
        height += np.float32(body.tilt_y) * y[:, :1]
    lowest = float(height.min())
    if not np.isfinite(lowest):
        raise ValueError(f"the shape of '{body.name}' has heights that are not finite")
    height -= np.float32(lowest)
    near = (height < np.float32(REACH_MM)).astype(np.float32)
    # Counted along each axis: a mean over the samples picked out costs five times as much.
    ones = np.ones(RASTER_SIDE, np.float32)
    by_column, by_row = ones @ near, near @ ones
    count = by_row.sum()
    middle = (float(by_column @ x[0] / count), float(by_row @ y[:, 0] / count))
    height.setflags(write=False)
    return Profile(height, middle, indenter.is_extended)
