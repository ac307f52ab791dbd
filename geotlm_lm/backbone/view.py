"""The square of the image that the patch grid covers, laid around the imprint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE

Floats = NDArray[np.float32]

CONTRAST_FLOOR_GREY2 = 4.0
"""Squared gradient at which contrast outweighs camera noise (sigma 1.2-2 grey)."""

VIEW_CELL_PX = 8
"""Cells on which the imprint is located."""

VIEW_RADII = 4.0
"""Side of the view in rms radii of the imprint's contrast; a uniform disc ends at 1.41 of them."""

MIN_VIEW_PX = 96.0
"""Smallest view: 7 mm on GelSight Mini; a smaller one magnifies the camera's noise."""


@dataclass(frozen=True)
class View:
    """The square of the image that the patch grid covers.

    Seven-region pooling tells a turn from a slide only where the halves of the grid see opposite
    sides of the contact; so the grid is laid around the imprint, wherever it is in the image.
    """

    centre_x_px: float = IMAGE_SIDE / 2  # column of the middle, pixels of the 224-pixel image
    centre_y_px: float = IMAGE_SIDE / 2  # row of the middle
    side_px: float = float(IMAGE_SIDE)  # side; smaller than 224 magnifies
    # Rows of the 224-pixel image that the picture fills, around its middle.
    picture_height_px: int = IMAGE_SIDE
    # Columns that it fills; idle gel surrounds it where it is of another shape than a camera's
    # (`core.geometry.filled_size`).
    picture_width_px: int = IMAGE_SIDE

    def in_picture(self, points: NDArray) -> NDArray:
        """Return where points (..., 2) of the view lie in the picture.

        Shares (x, y) of the view's side, from its upper left corner, become shares of the picture's
        width and height.
        """
        filled = np.array([self.picture_width_px, self.picture_height_px])
        corner = np.array([self.centre_x_px, self.centre_y_px]) - self.side_px / 2
        return (corner + points * self.side_px - (IMAGE_SIDE - filled) / 2) / filled

    def cut(self, image: NDArray) -> NDArray:
        """Return the view's part of a square image or grid at the same size; zero outside.

        It covers the whole 224-pixel image at any resolution, with or without channels.
        """
        pixels = image.shape[0] / IMAGE_SIDE
        middles = (self.centre_x_px, self.centre_y_px)
        corner = [pixels * (middle - self.side_px / 2) for middle in middles]
        side = pixels * self.side_px
        if all(float(length).is_integer() for length in (*corner, side)):
            left, top = map(int, corner)
            return _cropped(image, left, top, int(side))
        scale = self.side_px / IMAGE_SIDE
        x, y = (start + 0.5 * scale - 0.5 for start in corner)
        matrix = np.float32([[scale, 0, x], [0, scale, y]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(image, matrix, image.shape[:2], flags=flags)


def contact_view(energy: Sequence[Floats]) -> View:
    """Return the view around what stands out from the idle gel in any frame.

    `energy` is the mean squared gradient of the residual in each cell of `VIEW_CELL_PX` of each
    frame, grey^2 per px^2, (28, 28). The view is centred on the imprint to a pixel, between
    `MIN_VIEW_PX` and the whole image large, which it is where nothing stands out.
    """
    most = np.max(energy, axis=0)
    excess = np.sqrt(np.maximum(most - 2 * np.median(most) - CONTRAST_FLOOR_GREY2, 0))
    mass = float(excess.sum())
    if mass == 0:
        return View()
    centres = (np.arange(len(excess)) + 0.5) * VIEW_CELL_PX
    x = float(excess.sum(axis=0) @ centres) / mass
    y = float(excess.sum(axis=1) @ centres) / mass
    spread = excess.sum(axis=0) @ np.square(centres - x) + excess.sum(axis=1) @ np.square(
        centres - y
    )
    radius = float(np.sqrt(spread / mass))
    # Whole pixels are cut in a fifth of the time.
    side = float(round(min(max(VIEW_RADII * radius, MIN_VIEW_PX), IMAGE_SIDE)))
    left, top = (round(centre - side / 2) for centre in (x, y))
    return View(left + side / 2, top + side / 2, side)


def _cropped(image: NDArray, left: int, top: int, side: int) -> NDArray:
    """Return a square part of a square image at the image's size; zero outside of the image."""
    size = image.shape[0]
    inner = image[max(top, 0) : max(top + side, 0), max(left, 0) : max(left + side, 0)]
    if not inner.size:
        return np.zeros_like(image)
    before = max(-top, 0), max(-left, 0)
    after = max(top + side - size, 0), max(left + side - size, 0)
    if any((*before, *after)):
        kind = cv2.BORDER_CONSTANT
        inner = cv2.copyMakeBorder(inner, before[0], after[0], before[1], after[1], kind, value=0)
    return cv2.resize(inner, (size, size), interpolation=cv2.INTER_LINEAR)
