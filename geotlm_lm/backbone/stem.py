"""Four frames and the idle gel -> patch inputs: what changed, and how the change moved.

Sub-patch motion is a product of temporal and spatial gradients, which a small transformer trained
from scratch on pixels did not find; so the stem hands it motion beside the pixels: dense optical
flow of the residual, which keeps fine detail, and of the relief, which does not change its shade as
it turns; and the one rigid motion of the whole imprint, for both. It has no learned weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.backbone.alignment import CHANNELS as ALIGNMENT_CHANNELS
from geotlm_lm.backbone.alignment import alignment
from geotlm_lm.backbone.relief import RELIEF_SCALE, RELIEF_SIDE, as_image, reliefs
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import (
    FRAME_COUNT,
    GRID_SIDE,
    IMAGE_SIDE,
    TIME_BIN_COUNT,
    TUBE_FRAMES,
    pixel_aspect,
)

Floats = NDArray[np.float32]

CELLS = 4
"""Cells per patch side at which the residual is kept: 4 x 4 cells of 4 x 4 pixels."""

RESIDUAL_SCALE_GREY = 24.0
"""Grey levels mapped to 1: about one standard deviation of a real contact's residual (21-43)."""

FLOW_SCALE_PX = 4.0
"""Pixels of accumulated flow mapped to 1."""

CONTRAST_FLOOR_GREY2 = 4.0
"""Squared gradient at which contrast outweighs camera noise (sigma 1.2-2 grey)."""

FLOW_CHANNELS = 6
"""Flow x, flow y, log contrast, and the gradients' orientation (3)."""

FLOW_SIDE = 56
"""Side of the images whose flow is sought, a quarter of the view's resolution. Measured on 299
simulated turns and slides, direction read by a rigid fit inside the true contact, patches of 8 px:
0.98 and 0.93; at half of the view's resolution 0.98 and 0.90."""

RESIDUAL_PATCH_PX = 12
"""Side of a patch matched in the residual: on the same clips 0.99 and 0.94."""

RELIEF_PATCH_PX = 8
"""Side of a patch matched in the relief: patches of 8 px find 0.86 of a turn, of 12 px 0.83."""

PATCH_INPUT_DIM = 3 * CELLS**2 + 2 * FLOW_CHANNELS + 2 + 2 * ALIGNMENT_CHANNELS
"""RGB residual cells, then the flow channels of the residual and of the relief, then the relief and
the log of the view's magnification, then the alignment channels of the relief and of the
residual."""

MAGNIFICATION_AT = PATCH_INPUT_DIM - 2 * ALIGNMENT_CHANNELS - 1
"""Place of the view's magnification, the same in every patch: without it nobody could tell how far
on the gel a pixel of the view is."""

ALIGNED_AT = PATCH_INPUT_DIM - 2 * ALIGNMENT_CHANNELS
"""Place of the aligned relief's displacement x among a patch's inputs; displacement y follows."""


@dataclass(frozen=True)
class View:
    """The square of the image that the patch grid covers.

    Seven-region pooling tells a turn from a slide only where the halves of the grid see opposite
    sides of the contact; so the grid is laid around the imprint, wherever it is in the image.

    Args:
        centre_x_px: Column of the middle, pixels of the 224-pixel image.
        centre_y_px: Row of the middle.
        side_px: Side; smaller than 224 magnifies.
    """

    centre_x_px: float = IMAGE_SIDE / 2
    centre_y_px: float = IMAGE_SIDE / 2
    side_px: float = float(IMAGE_SIDE)

    def cut(self, image: NDArray, how: int = cv2.INTER_LINEAR) -> NDArray:
        """Return the view's part of a square image or grid at the same size; zero outside.

        Args:
            image: float32 or uint8, shape (side, side) or (side, side, channels), covering the
                whole 224-pixel image at any resolution.
            how: OpenCV's interpolation.
        """
        side = image.shape[0]
        pixels = side / IMAGE_SIDE
        scale = self.side_px / IMAGE_SIDE
        corner = [
            pixels * (centre - self.side_px / 2) + 0.5 * scale - 0.5
            for centre in (self.centre_x_px, self.centre_y_px)
        ]
        matrix = np.float32([[scale, 0, corner[0]], [0, scale, corner[1]]])
        return cv2.warpAffine(image, matrix, (side, side), flags=how | cv2.WARP_INVERSE_MAP)


def look(clip: Clip) -> tuple[Floats, View]:
    """Compute the inputs of one clip's patch tokens and the view they cover.

    Args:
        clip: Exactly four frames with a known or estimated background, any size.

    Returns:
        Inputs, shape (2, 14, 14, PATCH_INPUT_DIM), early time-bin first; flow is accumulated from
        the clip's first frame to the mean of the bin's two frames, x right, y down, in pixels of
        the view. And the view.

    Raises:
        ValueError: If the clip is not four frames with a background.
    """
    if len(clip) != FRAME_COUNT or clip.background is None:
        raise ValueError(f"the stem reads {FRAME_COUNT} frames and a background, found {len(clip)}")
    idle = _square(clip.background)
    whole = [cv2.subtract(_square(frame), idle) for frame in clip.frames]
    view = contact_view([_structure(_green(image)) for image in whole])
    residual = [view.cut(image) for image in whole]
    aspect = pixel_aspect(*clip.frames.shape[1:3])
    half = [_area_means(image, RELIEF_SIDE) for image in residual]
    relief = reliefs(half, aspect)
    magnification = np.log(IMAGE_SIDE / view.side_px)
    parts = [
        np.clip(_bin_means([_cells(image) for image in half]) / RESIDUAL_SCALE_GREY, -4, 4),
        _motion([_green(image) for image in residual], RESIDUAL_PATCH_PX),
        _motion([as_image(frame) for frame in relief], RELIEF_PATCH_PX),
        _bin_means([_area_means(frame, GRID_SIDE) for frame in relief])[..., None] / RELIEF_SCALE,
        np.full((TIME_BIN_COUNT, GRID_SIDE, GRID_SIDE, 1), magnification),
        _alignment(half, relief, aspect),
    ]
    return np.concatenate(parts, axis=-1, dtype=np.float32), view


def contact_view(structure: Sequence[Floats]) -> View:
    """Return the view around what stands out from the idle gel in any frame.

    Args:
        structure: Mean products of the residual's gradients in each cell of each frame, xx, xy, yy:
            (cells, cells, 3), a whole number of them on a cell of `VIEW_CELL_PX`.

    Returns:
        A view centred on the imprint, between `MIN_VIEW_PX` and the whole image large; the whole
        image where nothing stands out.
    """
    side = IMAGE_SIDE // VIEW_CELL_PX
    energy = np.max([_area_means(one[..., 0] + one[..., 2], side) for one in structure], axis=0)
    excess = np.sqrt(np.maximum(energy - 2 * np.median(energy) - CONTRAST_FLOOR_GREY2, 0))
    mass = float(excess.sum())
    if mass == 0:
        return View()
    centres = (np.arange(side) + 0.5) * VIEW_CELL_PX
    x = float(excess.sum(axis=0) @ centres) / mass
    y = float(excess.sum(axis=1) @ centres) / mass
    spread = excess.sum(axis=0) @ np.square(centres - x) + excess.sum(axis=1) @ np.square(
        centres - y
    )
    radius = float(np.sqrt(spread / mass))
    return View(x, y, min(max(VIEW_RADII * radius, MIN_VIEW_PX), IMAGE_SIDE))


VIEW_CELL_PX = 8
"""Cells on which the imprint is located."""

VIEW_RADII = 4.0
"""Side of the view in rms radii of the imprint's contrast; a uniform disc ends at 1.41 of them."""

MIN_VIEW_PX = 96.0
"""Smallest view: 7 mm on GelSight Mini; a smaller one magnifies the camera's noise."""


def _square(image: NDArray[np.uint8]) -> Floats:
    if image.shape[:2] != (IMAGE_SIDE, IMAGE_SIDE):
        shrinks = image.shape[0] > IMAGE_SIDE or image.shape[1] > IMAGE_SIDE
        how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        image = cv2.resize(image, (IMAGE_SIDE, IMAGE_SIDE), interpolation=how)
    return image.astype(np.float32)


def _green(residual: Floats) -> NDArray[np.uint8]:
    """Return the green residual as an 8-bit image around 128, doubled: flow needs the contrast.

    Red and blue lights shine from opposite sides, so their residuals largely cancel in a grey mean
    (correlation -0.77 to -0.80 on real contacts); and video codecs keep most detail in green.
    """
    return (128.0 + 2.0 * residual[..., 1]).clip(0, 255).astype(np.uint8)


def _cells(residual: Floats) -> Floats:
    """Average (side, side, 3), a multiple of 56, to (14, 14, 48): 4 x 4 cells of RGB per patch."""
    cells = _area_means(residual, GRID_SIDE * CELLS)
    cells = cells.reshape(GRID_SIDE, CELLS, GRID_SIDE, CELLS, 3)  # gh cell gw cell rgb
    return cells.transpose(0, 2, 1, 3, 4).reshape(GRID_SIDE, GRID_SIDE, -1)


def _area_means(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Average a square image to `side` pixels, each a whole number of its own; keeps the type."""
    # Measured 15 times faster than a numpy mean over two axes of the reshaped image.
    return cv2.resize(values, (side, side), interpolation=cv2.INTER_AREA)


def _bin_means(values: Sequence[Floats]) -> Floats:
    """Average the two frames of each time-bin: four arrays to shape (2, ...)."""
    stacked = np.stack(values)
    return stacked.reshape(-1, TUBE_FRAMES, *stacked.shape[1:]).mean(axis=1)


def _structure(green: NDArray[np.uint8]) -> Floats:
    """Return the mean products of gradients xx, xy, yy in each pixel of the flow, (56, 56, 3).

    In grey^2 per px^2.
    """
    image = cv2.GaussianBlur(green, (5, 5), 0)
    gx = cv2.Sobel(image, cv2.CV_32F, 1, 0, scale=1 / 8)
    gy = cv2.Sobel(image, cv2.CV_32F, 0, 1, scale=1 / 8)
    return cv2.merge([_area_means(one, FLOW_SIDE) for one in (gx * gx, gx * gy, gy * gy)])


def _orientation(structure: Floats) -> Floats:
    """Return log contrast and the normalised structure of each patch, shape (14, 14, 4)."""
    mean = _area_means(structure, GRID_SIDE)
    energy = mean[..., :1] + mean[..., 2:]
    log_contrast = np.log1p(energy / CONTRAST_FLOOR_GREY2)
    return np.concatenate([log_contrast, mean / (energy + CONTRAST_FLOOR_GREY2)], axis=-1)


def _solver(patch_px: int) -> cv2.DISOpticalFlow:
    """Return dense inverse search; variational smoothing gained nothing and took half again."""
    solver = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    solver.setFinestScale(0)
    solver.setPatchSize(patch_px)
    solver.setPatchStride(4)
    solver.setVariationalRefinementIterations(0)
    return solver


def _motion(images: list[NDArray[np.uint8]], patch_px: int) -> Floats:
    """Return flow, log contrast and orientation of each patch, (2, 14, 14, 6), early bin first."""
    structure = [_structure(image) for image in images]
    flow = _bin_means(_accumulated_flow(images, structure, patch_px)) / FLOW_SCALE_PX
    orientation = _bin_means([_orientation(products) for products in structure])
    return np.concatenate([flow, orientation], axis=-1)


def _alignment(residual: Sequence[Floats], relief: Sequence[Floats], aspect: float) -> Floats:
    """Return the alignment channels of each patch, (2, 14, 14, 12), early bin first."""
    frames = alignment(
        [frame / RELIEF_SCALE for frame in relief],
        [image[..., 1] / RESIDUAL_SCALE_GREY for image in residual],
        aspect,
    )
    for start in range(0, frames.shape[-1], ALIGNMENT_CHANNELS):
        moved = frames[..., start : start + 4]
        # Far from the middle a wrong turn moves a patch right out of the view.
        moved[:] = moved.clip(-IMAGE_SIDE, IMAGE_SIDE) / FLOW_SCALE_PX
    return _bin_means(frames)


def _accumulated_flow(
    images: list[NDArray[np.uint8]], structure: list[Floats], patch_px: int
) -> list[Floats]:
    """Sum each patch's contrast-weighted flow from the first frame on, (14, 14, 2) a frame.

    In pixels of the view.
    """
    solver = _solver(patch_px)
    # Shrunk once here: the solver would shrink both images of every pair, and spread its flow over
    # all their pixels again.
    small = [_area_means(image, FLOW_SIDE) for image in images]
    total = [np.zeros((GRID_SIDE, GRID_SIDE, 2), np.float32)]
    for before, after, products in zip(small[:-1], small[1:], structure[1:], strict=True):
        step = np.zeros_like(total[0])
        if not np.array_equal(before, after):
            weight = products[..., 0] + products[..., 2] + np.float32(1e-3)
            flow = solver.calc(before, after, None) * weight[..., None]
            step = _area_means(flow, GRID_SIDE) / _area_means(weight, GRID_SIDE)[..., None]
        total.append(total[-1] + step * np.float32(IMAGE_SIDE / FLOW_SIDE))
    return total
