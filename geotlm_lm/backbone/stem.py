"""Four frames and the idle gel -> patch inputs: what changed, and how the change moved.

Sub-patch motion is a product of temporal and spatial gradients, which a small transformer trained
from scratch on pixels did not find; so the stem hands it motion beside the pixels: dense optical
flow of the residual, which keeps fine detail, and of the relief, which does not change its shade as
it turns; and the one rigid motion of the whole imprint, for both. It has no learned weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.backbone.alignment import CHANNELS as ALIGNMENT_CHANNELS
from geotlm_lm.backbone.alignment import alignment
from geotlm_lm.backbone.lights import (
    as_of_one_light,
    lights_of,
    turned_by_a_half,
    turned_by_a_quarter,
)
from geotlm_lm.backbone.relief import RELIEF_SCALE, RELIEF_SIDE, as_image, is_inside_out, reliefs
from geotlm_lm.backbone.square import in_square
from geotlm_lm.backbone.view import CONTRAST_FLOOR_GREY2, VIEW_CELL_PX, View, contact_view
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import (
    FRAME_COUNT,
    GRID_SIDE,
    IMAGE_SIDE,
    TIME_BIN_COUNT,
    TUBE_FRAMES,
    filled_size,
    pixel_aspect,
)

Floats = NDArray[np.float32]

CELLS = 4
"""Cells per patch side at which the residual is kept: 4 x 4 cells of 4 x 4 pixels."""

RESIDUAL_SCALE_GREY = 24.0
"""Grey levels mapped to 1: about one standard deviation of a real contact's residual (21-43)."""

FLOW_SCALE_PX = 4.0
"""Pixels of accumulated flow mapped to 1."""

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

LAST_STEP = [ALIGNED_AT + start + place for start in (0, ALIGNMENT_CHANNELS) for place in (4, 5)]
"""Places of the gain over rest and the correlation of the step from the frame before, for the
relief and then for the residual."""

AT_REST = np.array([0.0, 1.0, 0.0, 1.0], np.float32)
"""What is told there of a frame that repeats the one before: no gain, full correlation; none at all
where nothing differs from the idle gel, as the alignment has it."""


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
    frames, places = _distinct(clip.frames)
    rows, columns = clip.frames.shape[1:3]
    filled, aspect = filled_size(rows, columns), pixel_aspect(rows, columns)
    whole = [in_square(frame, clip.background, filled) for frame in frames]
    view = contact_view([_energy(_green(image)) for image in whole])
    residual = [view.cut(image) for image in whole]
    residual, half, relief = _under_usual_lights(residual, aspect)
    parts = [
        np.stack([_cells(image) for image in half]) / RESIDUAL_SCALE_GREY,
        _motion([_green(image) for image in residual], RESIDUAL_PATCH_PX),
        _motion([as_image(frame) for frame in relief], RELIEF_PATCH_PX),
        np.stack([_area_means(frame, GRID_SIDE) for frame in relief])[..., None] / RELIEF_SCALE,
        np.full((len(frames), GRID_SIDE, GRID_SIDE, 1), np.log(IMAGE_SIDE / view.side_px)),
        _alignment(half, relief, aspect),
    ]
    view = replace(view, picture_height_px=filled[0], picture_width_px=filled[1])
    return _time_bins(np.concatenate(parts, axis=-1, dtype=np.float32), places), view


def _distinct(frames: NDArray[np.uint8]) -> tuple[list[NDArray[np.uint8]], list[int]]:
    """Return the frames that differ from the one before, and which of them stands at each place.

    A pair is fed as a, a, b, b, and an untouched gel as its idle frame alone: none is looked at
    twice.
    """
    distinct, places = [frames[0]], [0]
    for before, after in pairwise(frames):
        if not np.array_equal(before, after):
            distinct.append(after)
        places.append(len(distinct) - 1)
    return distinct, places


def _under_usual_lights(
    residual: list[Floats], aspect: float
) -> tuple[list[Floats], list[Floats], Floats]:
    """Return pictures as under a GelSight Mini's lights, shrunk to the relief's side, and reliefs.

    Without it a recording turned by a quarter, whose lights come from where no training clip had
    them, is told worse: of 271 real turns 242 for 261.
    """
    half = [_area_means(image, RELIEF_SIDE) for image in residual]
    lights = lights_of(half, aspect)
    if lights.are_one:
        residual, half = (list(map(as_of_one_light, images)) for images in (residual, half))
    elif lights.are_turned:
        residual, half = (list(map(turned_by_a_quarter, images)) for images in (residual, half))
    relief = reliefs(half, aspect, are_lights_mirrored=lights.are_mirrored)
    if is_inside_out(relief):
        residual, half = (list(map(turned_by_a_half, images)) for images in (residual, half))
        relief = -relief
    return residual, half, relief


def _green(residual: Floats) -> NDArray[np.uint8]:
    """Return the green residual as an 8-bit image around 128, doubled: flow needs the contrast.

    Red and blue lights shine from opposite sides, so their residuals largely cancel in a grey mean
    (correlation -0.77 to -0.80 on real contacts); and video codecs keep most detail in green.
    """
    green = cv2.extractChannel(residual, 1)
    # OpenCV rounds where it converts.
    return cv2.addWeighted(green, 2.0, green, 0.0, 127.5, dtype=cv2.CV_8U)


def _cells(residual: Floats) -> Floats:
    """Average (side, side, 3), a multiple of 56, to (14, 14, 48): 4 x 4 cells of RGB per patch."""
    cells = _area_means(residual, GRID_SIDE * CELLS)
    cells = cells.reshape(GRID_SIDE, CELLS, GRID_SIDE, CELLS, 3)  # gh cell gw cell rgb
    return cells.transpose(0, 2, 1, 3, 4).reshape(GRID_SIDE, GRID_SIDE, -1)


def _area_means(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Average a square image to `side` pixels, each a whole number of its own; keeps the type."""
    # Measured 15 times faster than a numpy mean over two axes of the reshaped image.
    return cv2.resize(values, (side, side), interpolation=cv2.INTER_AREA)


def _time_bins(inputs: Floats, places: list[int]) -> Floats:
    """Average the two frames of each time-bin: inputs of distinct frames to (2, 14, 14, dim).

    Args:
        inputs: Of each distinct frame, (distinct, 14, 14, dim).
        places: Which of them stands at each of the four places.
    """
    frames = inputs[places]
    for place in range(1, len(places)):
        if places[place] == places[place - 1]:
            frames[place][..., LAST_STEP] = AT_REST * frames[place][..., : 3 * CELLS**2].any()
    bins = frames.reshape(TIME_BIN_COUNT, TUBE_FRAMES, *frames.shape[1:]).mean(axis=1)
    residual = bins[..., : 3 * CELLS**2]
    np.clip(residual, -4, 4, out=residual)
    return bins


def _structure(green: NDArray[np.uint8]) -> Floats:
    """Return the mean products of gradients xx, xy, yy in each pixel of the flow, (56, 56, 3).

    In grey^2 per px^2.
    """
    gx, gy = _gradients(green)
    return cv2.merge([_area_means(one, FLOW_SIDE) for one in (gx * gx, gx * gy, gy * gy)])


def _energy(green: NDArray[np.uint8]) -> Floats:
    """Return the mean squared gradient in cells of `VIEW_CELL_PX`, grey^2 per px^2, (28, 28)."""
    gx, gy = _gradients(green)
    return _area_means(gx * gx + gy * gy, IMAGE_SIDE // VIEW_CELL_PX)


def _gradients(green: NDArray[np.uint8]) -> tuple[Floats, Floats]:
    """Return the slopes of a smoothed image towards right and down, grey levels per pixel."""
    image = cv2.GaussianBlur(green, (5, 5), 0)
    gx = cv2.Sobel(image, cv2.CV_32F, 1, 0, scale=1 / 8)
    gy = cv2.Sobel(image, cv2.CV_32F, 0, 1, scale=1 / 8)
    return gx, gy


def _orientation(structure: Floats) -> Floats:
    """Return log contrast and the normalised structure of each patch, shape (14, 14, 4)."""
    mean = _area_means(structure, GRID_SIDE)
    energy = mean[..., :1] + mean[..., 2:]
    log_contrast = np.log1p(energy / CONTRAST_FLOOR_GREY2)
    return np.concatenate([log_contrast, mean / (energy + CONTRAST_FLOOR_GREY2)], axis=-1)


def _solver(patch_px: int) -> cv2.DISOpticalFlow:
    """Return dense inverse search; variational smoothing gained nothing and took half again.

    Patches overlap by half. Those of 12 px a third of their side apart move the fused token by 2 %
    of its deviation, as much as a view half a pixel off does, and take a tenth of the stem more.
    """
    solver = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    solver.setFinestScale(0)
    solver.setPatchSize(patch_px)
    solver.setPatchStride(patch_px // 2)
    solver.setVariationalRefinementIterations(0)
    return solver


def _motion(images: list[NDArray[np.uint8]], patch_px: int) -> Floats:
    """Return flow, log contrast and orientation of each patch, (frames, 14, 14, 6)."""
    structure = [_structure(image) for image in images]
    flow = np.stack(_accumulated_flow(images, structure, patch_px)) / FLOW_SCALE_PX
    orientation = np.stack([_orientation(products) for products in structure])
    return np.concatenate([flow, orientation], axis=-1)


def _alignment(residual: Sequence[Floats], relief: Sequence[Floats], aspect: float) -> Floats:
    """Return the alignment channels of each patch, (frames, 14, 14, 12)."""
    frames = alignment(
        [frame / RELIEF_SCALE for frame in relief],
        [image[..., 1] / RESIDUAL_SCALE_GREY for image in residual],
        aspect,
    )
    for start in range(0, frames.shape[-1], ALIGNMENT_CHANNELS):
        moved = frames[..., start : start + 4]
        # Far from the middle a wrong turn moves a patch right out of the view.
        moved[:] = moved.clip(-IMAGE_SIDE, IMAGE_SIDE) / FLOW_SCALE_PX
    return frames


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
    # As far as patches reach on one side and on the other: a mirror must not change the flow.
    margin = -(FLOW_SIDE - patch_px) % (patch_px // 2) // 2
    inside = slice(margin, margin + FLOW_SIDE)
    small = [cv2.copyMakeBorder(one, *[margin] * 4, cv2.BORDER_REPLICATE) for one in small]
    total = [np.zeros((GRID_SIDE, GRID_SIDE, 2), np.float32)]
    for before, after, products in zip(small[:-1], small[1:], structure[1:], strict=True):
        weight = products[..., 0] + products[..., 2] + np.float32(1e-3)
        flow = solver.calc(before, after, None)[inside, inside] * weight[..., None]
        step = _area_means(flow, GRID_SIDE) / _area_means(weight, GRID_SIDE)[..., None]
        total.append(total[-1] + step * np.float32(IMAGE_SIDE / FLOW_SIDE))
    return total
