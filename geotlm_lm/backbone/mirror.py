"""Patch inputs of a scene seen in a mirror: more looks at a simulated clip, for next to no time.

Left for right they are what the stem makes of the mirrored frames, but for the rounding of its
alignments. Top for bottom the stem would take the lights for others and find another relief; these
inputs keep the true one.
"""

from __future__ import annotations

import math
from enum import Enum
from functools import lru_cache

import torch
from torch import Tensor

from geotlm_lm.backbone.stem import (
    ALIGNED_AT,
    ALIGNED_DIM,
    CELLS,
    LOCAL_AT,
    PATCH_INPUT_DIM,
)
from geotlm_lm.core.geometry import GRID_SIDE

_COLOURS = 3
_PICTURE = _COLOURS * CELLS**2
_CROSS_AT = LOCAL_AT + 5  # place of the gradients' product x y


class Mirror(Enum):
    """What a mirror swaps; the value is the place of that axis in (row, column)."""

    TOP_AND_BOTTOM = 0
    LEFT_AND_RIGHT = 1


def mirrored_inputs(inputs: Tensor, mirror: Mirror) -> Tensor:
    """Return patch inputs with the scene, its motion and its lights on the other side.

    Args:
        inputs: As `stem.look` makes them, (b, 2, 14, 14, PATCH_INPUT_DIM).
        mirror: What is swapped.
    """
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
    cells = source[..., :_PICTURE].unflatten(-1, (CELLS, CELLS, _COLOURS))
    source[..., :_PICTURE] = cells.flip(cells.ndim - 3 + axis).flatten(-3)
    sign = torch.ones(shape)
    sign[..., _signed_channels(mirror)] = -1
    return source.flatten(), sign.flatten()


def _signed_channels(mirror: Mirror) -> list[int]:
    """Return the places of what changes its sign: motion along the axis, and products x y."""
    along = 1 - mirror.value
    moved = [ALIGNED_AT + place + along for place in range(0, ALIGNED_DIM, 2)]
    return [*moved, LOCAL_AT + along, _CROSS_AT]
