"""Four frames and the idle gel -> patch inputs: what changed, and how the change moved.

Sub-patch motion is a product of temporal and spatial gradients, which a small transformer trained
from scratch on pixels did not find; so the stem hands it motion beside the pixels: dense optical
flow of the residual, which keeps fine detail, and of the relief, which does not change its shade as
it turns; and the one rigid motion of the whole imprint, for both. It has no learned weight.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.backbone.alignment import CHANNELS as ALIGNMENT_CHANNELS
from geotlm_lm.backbone.alignment import alignment
from geotlm_lm.backbone.alignment_images import AlignmentImages, alignment_images_of
from geotlm_lm.backbone.imprint import (
    RESIDUAL_SCALE_GREY,
    area_means,
    gradients,
    green_image,
    imprint_of,
)
from geotlm_lm.backbone.relief import RELIEF_SCALE, as_image
from geotlm_lm.backbone.view import CONTRAST_FLOOR_GREY2, View
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import (
    FLOW_SCALE_PX,
    GRID_SIDE,
    IMAGE_SIDE,
    TIME_BIN_COUNT,
    TUBE_FRAMES,
)

Floats = NDArray[np.float32]

CELLS = 4
"""Cells per patch side at which the residual is kept: 4 x 4 cells of 4 x 4 pixels."""

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


class StemMeasurement(NamedTuple):
    """What the stem measures in a clip.

    Args:
        inputs: Of its patch tokens, (2, 14, 14, PATCH_INPUT_DIM), early time-bin first; flow is
            accumulated from the clip's first frame to the mean of the bin's two frames, x right,
            y down, in pixels of the view.
        view: The square of the picture they cover.
        alignment_images: What was aligned, for finer measurements.
    """

    inputs: Floats
    view: View
    alignment_images: AlignmentImages


def measure_clip(clip: Clip) -> StemMeasurement:
    """Compute the inputs of one clip's patch tokens.

    Args:
        clip: Exactly four frames with a known or estimated background, any size.

    Raises:
        ValueError: If the clip is not four frames with a background.
    """
    imprint = imprint_of(clip)
    traces = alignment_images_of(imprint)
    half, relief = imprint.half, imprint.relief
    parts = [
        np.stack([_cells(image) for image in half]) / RESIDUAL_SCALE_GREY,
        _motion([green_image(image) for image in imprint.residual], RESIDUAL_PATCH_PX),
        _motion([as_image(frame) for frame in relief], RELIEF_PATCH_PX),
        np.stack([area_means(frame, GRID_SIDE) for frame in relief])[..., None] / RELIEF_SCALE,
        np.full((len(relief), GRID_SIDE, GRID_SIDE, 1), np.log(IMAGE_SIDE / imprint.view.side_px)),
        _alignment(traces),
    ]
    inputs = _time_bins(np.concatenate(parts, axis=-1, dtype=np.float32), imprint.places)
    return StemMeasurement(inputs, imprint.view, traces)


def _cells(residual: Floats) -> Floats:
    """Average (side, side, 3), a multiple of 56, to (14, 14, 48): 4 x 4 cells of RGB per patch."""
    cells = area_means(residual, GRID_SIDE * CELLS)
    cells = cells.reshape(GRID_SIDE, CELLS, GRID_SIDE, CELLS, 3)  # gh cell gw cell rgb
    return cells.transpose(0, 2, 1, 3, 4).reshape(GRID_SIDE, GRID_SIDE, -1)


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
    gx, gy = gradients(green)
    return cv2.merge([area_means(one, FLOW_SIDE) for one in (gx * gx, gx * gy, gy * gy)])


def _orientation(structure: Floats) -> Floats:
    """Return log contrast and the normalised structure of each patch, shape (14, 14, 4)."""
    mean = area_means(structure, GRID_SIDE)
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


def _alignment(traces: AlignmentImages) -> Floats:
    """Return the alignment channels of each patch, (frames, 14, 14, 12)."""
    frames = alignment(traces.relief, traces.green, traces.aspect)
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
    small = [area_means(image, FLOW_SIDE) for image in images]
    # As far as patches reach on one side and on the other: a mirror must not change the flow.
    margin = -(FLOW_SIDE - patch_px) % (patch_px // 2) // 2
    inside = slice(margin, margin + FLOW_SIDE)
    small = [cv2.copyMakeBorder(one, *[margin] * 4, cv2.BORDER_REPLICATE) for one in small]
    total = [np.zeros((GRID_SIDE, GRID_SIDE, 2), np.float32)]
    for before, after, products in zip(small[:-1], small[1:], structure[1:], strict=True):
        weight = products[..., 0] + products[..., 2] + np.float32(1e-3)
        flow = solver.calc(before, after, None)[inside, inside] * weight[..., None]
        step = area_means(flow, GRID_SIDE) / area_means(weight, GRID_SIDE)[..., None]
        total.append(total[-1] + step * np.float32(IMAGE_SIDE / FLOW_SIDE))
    return total
