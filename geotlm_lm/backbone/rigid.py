"""A turn and a shift of a small square image: what one rigid motion of an imprint does to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import GRID_SIDE

Floats = NDArray[np.float32]

SIDE = 56
"""Side of the images that are aligned; finer ones gained nothing and took three times as long."""

MIDDLE = (SIDE - 1) / 2
"""Place of the middle among an image's pixels."""


@dataclass(frozen=True)
class Rigid:
    """A turn about the middle of the view, then a shift.

    Args:
        turn_rad: Positive clockwise as drawn.
        x_px: Shift to the right, pixels of the aligned images.
        y_px: Shift down.
        aspect: Width of a pixel over its height; a turn is rigid on the gel, not in an image that
            was squashed to a square.
    """

    turn_rad: float = 0.0
    x_px: float = 0.0
    y_px: float = 0.0
    aspect: float = 1.0

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The turn in pixels, (2, 2)."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[cos, -sin / self.aspect], [sin * self.aspect, cos]])

    def after(self, first: Rigid) -> Rigid:
        """Return `first` followed by this motion."""
        (a, b), (c, d) = self.matrix.tolist()
        x = a * first.x_px + b * first.y_px + self.x_px
        y = c * first.x_px + d * first.y_px + self.y_px
        return Rigid(self.turn_rad + first.turn_rad, x, y, self.aspect)

    def way_back(self) -> NDArray[np.float64]:
        """Return where each pixel after the motion came from, an affine map (2, 3)."""
        (a, b), (c, d) = self._back().tolist()
        x, y = MIDDLE + self.x_px, MIDDLE + self.y_px
        return np.array([[a, b, MIDDLE - a * x - b * y], [c, d, MIDDLE - c * x - d * y]])

    def moved(self, image: Floats) -> Floats:
        """Return a square image of side `SIDE` after the motion; zero comes in from outside."""
        return warped(image, self.way_back())

    def displacement(self) -> Floats:
        """Return how far the point now under each patch centre has come, (14, 14, 2), pixels."""
        return self.way_to(np.stack(_patch_centres(), axis=-1))

    def way_to(self, points: Floats) -> Floats:
        """Return how far what is now at each point has come, (..., 2) likewise.

        Args:
            points: x and y in pixels from the image's middle.
        """
        return points - (points - np.float32([self.x_px, self.y_px])) @ self._back().T

    def _back(self) -> NDArray[np.float32]:
        """Return the turn back, (2, 2)."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[cos, sin / self.aspect], [-sin * self.aspect, cos]], np.float32)


def warped(image: Floats, back: NDArray[np.float64]) -> Floats:
    """Return an image of side `SIDE` whose pixels came from where `back` says, a map (2, 3)."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(image, back, (SIDE, SIDE), flags=flags)


@lru_cache(maxsize=1)
def _patch_centres() -> tuple[Floats, Floats]:
    axis = ((np.arange(GRID_SIDE) + 0.5) * SIDE / GRID_SIDE - SIDE / 2).astype(np.float32)
    return np.meshgrid(axis, axis)
