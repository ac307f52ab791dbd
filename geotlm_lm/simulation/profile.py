"""The object's underside as a sampled height map, placed by a pose; knows no gel and no light.

A profile is f(x, y) >= 0 in mm above the object's lowest point, sampled on a square raster in the
object's own frame, plus an exact tilt plane. Outside a finite object it is `OUTSIDE_MM`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.raster import OUTSIDE_MM, RASTER_MM, RASTER_SIDE, object_grid
from geotlm_lm.simulation.scene import Body
from geotlm_lm.simulation.smooth_field import smooth_field

HeightMap = NDArray[np.float32]

REACH_MM = 0.4
"""Height band whose centroid counts as the middle of the contact; a typical pressing depth."""

FINE_PER_CELL = 5
"""Samples per contact cell and axis; odd, so that one of them is the cell's centre."""


@dataclass(frozen=True, eq=False)
class Profile:
    """A body ready to be placed.

    Args:
        height_mm: float32 (RASTER_SIDE, RASTER_SIDE), the body without its tilt.
        tilt: Slopes (x, y) of the tilt plane in the object's frame.
        middle_mm: Point of the object's frame that a pose's (x, y) places.
        lowest_mm: Lowest value of height + tilt plane; subtracted.
        is_extended: The body goes on beyond the raster (mirrored there) instead of ending.
    """

    height_mm: HeightMap
    tilt: tuple[float, float]
    middle_mm: tuple[float, float]
    lowest_mm: float
    is_extended: bool

    def sample(
        self,
        pose: tuple[float, float, float],
        mm_per_px: tuple[float, float],
        side: int,
    ) -> HeightMap:
        """Return f on a square image of the gel frame whose middle is the view's middle.

        Args:
            pose: (x_mm, y_mm, rotation_rad) of the object.
            mm_per_px: Pixel size (x, y).
            side: Pixels per side.
        """
        x_mm, y_mm, angle = pose
        cos, sin = np.cos(angle), np.sin(angle)
        columns = (np.arange(side) - (side - 1) / 2) * mm_per_px[0] - x_mm
        rows = (np.arange(side) - (side - 1) / 2) * mm_per_px[1] - y_mm
        # Gel frame -> object frame is the inverse turn, then the offset of the object's middle.
        origin_x = cos * columns[0] + sin * rows[0] + self.middle_mm[0]
        origin_y = -sin * columns[0] + cos * rows[0] + self.middle_mm[1]
        raster = RASTER_MM / RASTER_SIDE
        matrix = np.array(
            [
                [cos * mm_per_px[0], sin * mm_per_px[1], origin_x + RASTER_MM / 2 - raster / 2],
                [-sin * mm_per_px[0], cos * mm_per_px[1], origin_y + RASTER_MM / 2 - raster / 2],
            ]
        )
        height = cv2.warpAffine(
            self.height_mm,
            matrix / raster,
            (side, side),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REFLECT_101 if self.is_extended else cv2.BORDER_CONSTANT,
            borderValue=OUTSIDE_MM,
        )
        slope_x = cos * self.tilt[0] - sin * self.tilt[1]
        slope_y = sin * self.tilt[0] + cos * self.tilt[1]
        level = self.tilt[0] * self.middle_mm[0] + self.tilt[1] * self.middle_mm[1]
        plane = (slope_x * columns + level - self.lowest_mm).astype(np.float32)[None, :]
        height += plane + (slope_y * rows).astype(np.float32)[:, None]
        return height

    def on_cells(self, pose: tuple[float, float, float], box_mm: float, side: int) -> HeightMap:
        """Return f on the contact grid; a feature narrower than a cell keeps its lowest point."""
        cell = box_mm / side
        fine = self.sample(pose, (cell / FINE_PER_CELL,) * 2, side * FINE_PER_CELL)
        return pool_to_cells(fine, FINE_PER_CELL)

    def overlap_area_mm2(self, depth_mm: float) -> float:
        """Return the area of the object lower than `depth_mm` above its lowest point."""
        return float((self._coarse() < depth_mm).mean() * RASTER_MM**2)

    def depth_for_area(self, area_mm2: float) -> float:
        """Return the depth at which `area_mm2` of the object lies below it."""
        values = self._coarse().ravel()
        rank = min(int(area_mm2 / RASTER_MM**2 * values.size), values.size - 1)
        return float(np.partition(values, rank)[rank])

    def _coarse(self) -> HeightMap:
        x, y = object_grid()
        step = (slice(None, None, 4), slice(None, None, 4))
        plane = self.tilt[0] * x[step] + self.tilt[1] * y[step]
        return self.height_mm[step] + plane - np.float32(self.lowest_mm)


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
    height = indenter.height(x / scale, y / scale, rng) * scale
    if body.texture_um > 0:
        texture = smooth_field(rng, RASTER_SIDE, body.texture_scale_mm / (RASTER_MM / RASTER_SIDE))
        height = height + np.float32(body.texture_um * 1e-3) * texture
    height = np.ascontiguousarray(np.minimum(height, OUTSIDE_MM), dtype=np.float32)
    if not np.isfinite(height).all():
        raise ValueError(f"the shape of '{body.name}' has heights that are not finite")
    # A body that bends away everywhere only shows another spot when tilted; a finite one leans.
    tilt = (0.0, 0.0) if indenter.is_extended else (body.tilt_x, body.tilt_y)
    whole = height + np.float32(tilt[0]) * x + np.float32(tilt[1]) * y
    lowest = float(whole.min())
    near = whole < lowest + REACH_MM
    middle = (float(x[near].mean()), float(y[near].mean()))
    return Profile(height, tilt, middle, lowest, indenter.is_extended)
