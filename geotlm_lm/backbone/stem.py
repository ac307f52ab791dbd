"""Four frames and the idle gel -> patch inputs: what changed, and how the change moved.

Sub-patch motion is a product of temporal and spatial gradients, which a small transformer trained
from scratch on pixels did not find; so the stem hands it motion beside the pixels: one rigid motion
of the whole imprint, found directly in the green residual and again in the relief, which does not
change its shade as it turns; and what each patch moved beyond it. It has no learned weight.
"""

from __future__ import annotations

import math
from enum import Enum
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.imprint import RESIDUAL_SCALE_GREY, area_means, imprint_of
from geotlm_lm.backbone.motions import (
    LOCAL_CHANNELS,
    MOTION_NUMBERS,
    Motions,
    motions_of,
)
from geotlm_lm.backbone.relief import RELIEF_SCALE
from geotlm_lm.backbone.view import View
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

RESIDUAL_DIM = 3 * CELLS**2

RELIEF_AT = RESIDUAL_DIM
"""Place of the relief's mean; the log of the view's magnification follows, the same in every patch:
without it a pixel of the view would have no length on the gel."""

MAGNIFICATION_AT = RELIEF_AT + 1

ALIGNED_AT = MAGNIFICATION_AT + 1
"""Place of the displacements by the rigid motions, x before y: of the green residual, chained and
laid on the first frame directly, then of the relief likewise."""

ALIGNED_DIM = 8

LOCAL_AT = ALIGNED_AT + ALIGNED_DIM
"""Place of what each patch shows beyond the rigid motion, `LOCAL_CHANNELS` numbers."""

PATCH_INPUT_DIM = LOCAL_AT + LOCAL_CHANNELS + MOTION_NUMBERS
"""With how surely each rigid motion was found behind them, the same in every patch."""


class StemMeasurement(NamedTuple):
    """What the stem measures in a clip."""

    # Of its patch tokens, (2, 14, 14, PATCH_INPUT_DIM), early time-bin first; motion is from the
    # clip's first frame to the mean of the bin's two frames, x right, y down, in units of
    # `FLOW_SCALE_PX` pixels of the view.
    inputs: Floats
    view: View  # the square of the picture they cover
    motions: Motions  # the rigid motions to the last frame


def measure_clip(clip: Clip) -> StemMeasurement:
    """Measure a clip of exactly four frames with a known or estimated background, any size."""
    imprint = imprint_of(clip)
    motions = motions_of(imprint)
    grid = (len(imprint.cells), GRID_SIDE, GRID_SIDE)
    parts = [
        np.stack([_cells(image) for image in imprint.cells]) / RESIDUAL_SCALE_GREY,
        np.stack([area_means(frame, GRID_SIDE) for frame in imprint.relief])[..., None]
        / RELIEF_SCALE,
        np.full((*grid, 1), np.log(IMAGE_SIDE / imprint.view.side_px)),
        motions.displacement.clip(-IMAGE_SIDE, IMAGE_SIDE) / FLOW_SCALE_PX,
        motions.local,
        np.broadcast_to(motions.sureness[:, None, None], (*grid, MOTION_NUMBERS)),
    ]
    frames = np.concatenate(parts, axis=-1, dtype=np.float32)[imprint.places]
    # The mean of the two frames of each time-bin, (2, 14, 14, dim).
    inputs = frames.reshape(TIME_BIN_COUNT, TUBE_FRAMES, *frames.shape[1:]).mean(axis=1)
    residual = inputs[..., :RESIDUAL_DIM]
    np.clip(residual, -4, 4, out=residual)
    return StemMeasurement(inputs, imprint.view, motions.motions)


def _cells(residual: Floats) -> Floats:
    """Regroup (56, 56, 3) to (14, 14, 48): 4 x 4 cells of RGB per patch."""
    cells = residual.reshape(GRID_SIDE, CELLS, GRID_SIDE, CELLS, 3)  # gh cell gw cell rgb
    return cells.transpose(0, 2, 1, 3, 4).reshape(GRID_SIDE, GRID_SIDE, -1)


class Mirror(Enum):
    """What a mirror swaps; the value is the place of that axis in (row, column).

    Patch inputs of a scene seen in a mirror are more looks at a simulated clip, for next to no
    time. Left for right they are what the stem makes of the mirrored frames, but for the rounding
    of its alignments. Top for bottom the stem would take the lights for others and find another
    relief; these inputs keep the true one.
    """

    TOP_AND_BOTTOM = 0
    LEFT_AND_RIGHT = 1


def mirrored_inputs(inputs: Tensor, mirror: Mirror) -> Tensor:
    """Return patch inputs (b, 2, 14, 14, dim) with scene, motion and lights on the other side."""
    source, sign = _places(mirror)
    turned = inputs.flatten(2).index_select(-1, source.to(inputs.device)) * sign.to(inputs)
    return turned.view_as(inputs)


def mirrored_field(field: Tensor, mirror: Mirror) -> Tensor:
    """Return a vector field on the patch grid, x right and y down, (b, 2, 14, 14, 2), likewise."""
    turned = field.flip(2 + mirror.value)
    turned[..., 1 - mirror.value] *= -1
    return turned


@lru_cache(maxsize=len(Mirror))
def _places(mirror: Mirror) -> tuple[Tensor, Tensor]:
    """Return where every input of one time-bin comes from, and its sign."""
    axis = mirror.value
    shape = (GRID_SIDE, GRID_SIDE, PATCH_INPUT_DIM)
    source = torch.arange(math.prod(shape)).view(shape).flip(axis)
    cells = source[..., :RESIDUAL_DIM].unflatten(-1, (CELLS, CELLS, 3))
    source[..., :RESIDUAL_DIM] = cells.flip(cells.ndim - 3 + axis).flatten(-3)
    sign = torch.ones(shape)
    # Motion along the axis changes its sign, and the gradients' product x y.
    along = 1 - axis
    moved = [ALIGNED_AT + place + along for place in range(0, ALIGNED_DIM, 2)]
    sign[..., [*moved, LOCAL_AT + along, LOCAL_AT + 5]] = -1
    return source.flatten(), sign.flatten()
