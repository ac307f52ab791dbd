"""The raster on which objects are sampled in their own frame; knows no object."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

RASTER_SIDE = 400
"""Samples per side of an object's height map."""

RASTER_MM = 25.6
"""Side of the height map in mm; the size of GelSight Mini's pad, finer than its camera's pixels."""

PX_PER_MM = RASTER_SIDE / RASTER_MM

OUTSIDE_MM = 1000.0
"""Height standing for 'no object here': far above any depth, finite so that it interpolates."""


@cache
def object_grid() -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return x and y of every sample in mm, float32 (RASTER_SIDE, RASTER_SIDE), read-only."""
    axis = ((np.arange(RASTER_SIDE) + 0.5) / RASTER_SIDE - 0.5) * RASTER_MM
    x, y = np.meshgrid(axis.astype(np.float32), axis.astype(np.float32))
    x.setflags(write=False)
    y.setflags(write=False)
    return x, y
