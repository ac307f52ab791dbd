"""Dots on the gel to their shade in the image; knows no object, no light and no label."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.scene import Markers, Optics

FLATNESS = 3.0
"""How flat a dot's middle is: its shade is 1 - exp(-FLATNESS g), g a Gaussian of height 1."""

_HALF_WIDTH = float(np.sqrt(-2 * np.log(np.log(2) / FLATNESS)))
"""Radius of half the darkness in standard deviations of that Gaussian."""


def shade(
    markers: Markers, optics: Optics, drift_mm: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """Return the share of light that the dots leave, float32 (224, 224), 1 between them.

    A dot belongs to a point of the gel: it stands where that point has been carried, to any
    fraction of a pixel.

    Args:
        markers: The grid.
        optics: Pixel size and mounting.
        drift_mm: Tangential displacement of the gel from rest, (2, 224, 224), x before y, at each
            point's place at rest; None for a gel at rest.
    """
    size = np.array([optics.mm_per_px_x, optics.mm_per_px_y])
    x, y = _moved(resting_px(markers, optics), size, drift_mm)
    sigma = markers.diameter_mm / 2 / _HALF_WIDTH / size
    pixels = np.arange(IMAGE_SIDE)
    across = np.exp(-0.5 * ((pixels - x[:, None]) / sigma[0]) ** 2).astype(np.float32)
    down = np.exp(-0.5 * ((pixels - y[:, None]) / sigma[1]) ** 2).astype(np.float32)
    dots = 1 - np.exp(-FLATNESS * (down.T @ across))
    return (1 - np.float32(markers.darkness) * dots).astype(np.float32)


def resting_px(markers: Markers, optics: Optics) -> NDArray[np.float64]:
    """Return where the dots of a gel at rest lie, (2, n) pixels, x before y.

    The grid goes on one spacing beyond the view: what is carried into it is seen.
    """
    mounting, size = optics.mounting, np.array([[optics.mm_per_px_x], [optics.mm_per_px_y]])
    half_mm = IMAGE_SIDE / 2 * size
    reach = np.hypot(*half_mm[:, 0]) + np.hypot(mounting.x_mm, mounting.y_mm)
    count = int(np.ceil(reach / markers.spacing_mm)) + 1
    steps = np.arange(-count, count + 1) * markers.spacing_mm
    grid = np.stack([axis.ravel() for axis in np.meshgrid(steps, steps)])
    grid = grid + [[markers.x_mm], [markers.y_mm]]
    cos, sin = np.cos(mounting.turn_rad), np.sin(mounting.turn_rad)
    place = np.array([[cos, -sin], [sin, cos]]) @ grid + [[mounting.x_mm], [mounting.y_mm]]
    place = place[:, (np.abs(place) <= half_mm + markers.spacing_mm).all(axis=0)]
    return place / size + (IMAGE_SIDE - 1) / 2


def _moved(
    rest_px: NDArray[np.float64],
    size_mm: NDArray[np.float64],
    drift_mm: NDArray[np.float32] | None,
) -> NDArray[np.float64]:
    if drift_mm is None:
        return rest_px
    inside = np.clip(rest_px, 0, IMAGE_SIDE - 1)
    column, row = np.minimum(inside.astype(int), IMAGE_SIDE - 2)
    right, low = inside[0] - column, inside[1] - row
    upper = (1 - right) * drift_mm[:, row, column] + right * drift_mm[:, row, column + 1]
    lower = (1 - right) * drift_mm[:, row + 1, column] + right * drift_mm[:, row + 1, column + 1]
    return rest_px + ((1 - low) * upper + low * lower) / size_mm[:, None]
