"""Sparsh V-JEPA (facebookresearch/sparsh): tubes of two frames, newest first, no global token."""

from __future__ import annotations

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.adapters.vit_adapter import TIMM_BLOCK, ViTAdapter
from geotlm_lm.backbone.image_vit import ImageViT, sinusoid_frequencies
from geotlm_lm.backbone.pixels import (
    Size,
    background,
    four_frames,
    resized,
    rounded,
    to_unit,
    unsquashed,
)
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import TIME_BIN_COUNT

TITLE = "Sparsh V-JEPA"
ASPECT = 4 / 3
"""Columns over rows of a picture of which the authors cut nothing."""

NORM_EPS = 1e-6


def upright_difference(clip: Clip, image: Size) -> Tensor:
    """Return (3, 4, rows, columns) in [0, 1], newest frame first, landscape pictures upright.

    The authors turn landscape pictures by 90 degrees clockwise; `upright_tokens` turns the grid
    back. Others they leave as they are, which would give a grid of another shape: a portrait
    picture that comes turned counterclockwise is seen as they show it.

    Raises:
        UnreadableClip: If the picture is not wider than high.
    """
    idle = unsquashed(background(clip))
    rows, columns = idle.shape[:2]
    if columns <= rows:
        raise UnreadableClip(
            f"{clip.name}: frames are {columns}x{rows} pixels, {TITLE} reads pictures wider than "
            f"high; turn the recording by 90 degrees counterclockwise, or export all of the "
            f"camera's picture."
        )
    frames = [_upright(_difference(unsquashed(f), idle)) for f in four_frames(clip)[::-1]]
    return rounded(resized(to_unit(np.stack(frames)), image)).transpose(0, 1)


def upright_tokens(module: ImageViT, pixels: Tensor) -> Tokens:
    """Return tokens of clips (b, 3, 4, rows, columns), early bin first, rows as in the camera.

    There is no global token: the mean over the patches stands for it.
    """
    grid = module.patch_grid(module.normed(module(pixels)))
    mean = grid.flatten(1, 3).mean(dim=1)
    return Tokens(mean, torch.rot90(grid.flip(1), 1, dims=(2, 3)))


def uncut_view(clip: Clip) -> View | None:
    """Return the whole image, or None where the authors' cut makes it no square."""
    rows, columns = unsquashed(clip.frames[0]).shape[:2]
    return View() if columns / rows == ASPECT else None


def _difference(frame: NDArray[np.uint8], idle: NDArray[np.uint8]) -> NDArray[np.uint8]:
    difference = (frame.astype(np.int32) - idle.astype(np.int32)) / 255 + 0.5
    return (difference.clip(0, 1) * 255).astype(np.uint8)


def _upright(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Turn a landscape picture upright, and cut rows where it is not 4 by 3, as the authors do."""
    image = cv2.rotate(image, cv2.ROTATE_90_CLOCKWISE)
    rows, columns = image.shape[:2]
    if rows / columns == ASPECT:
        return image
    kept = int(rows / ASPECT)
    return image[int((rows - kept) / 2) : int((rows + kept) / 2)]


SPARSH = ViTAdapter(
    name="sparsh",
    title=TITLE,
    source="https://huggingface.co/facebook/sparsh-vjepa-base (vjepa_vitbase.safetensors)",
    marks=({"patch_embed.proj.weight": 5},),
    anchors={
        "patch_embed.proj.weight": 5,
        "blocks.0.mlp.fc1.weight": 2,
        "blocks.0.ls1.gamma": 1,
    },
    pixels=upright_difference,
    tokens=upright_tokens,
    view=uncut_view,
    # Of a training checkpoint; the context encoder in it has the same names and other numbers.
    prefixes=("target_encoder.", "backbone."),
    released_heads={768: 12},
    # A file may lack registers, and positions where they are computed.
    weights={
        "patch": "patch_embed.proj",
        "norm": "norm",
        "registers": "register_tokens",
        "positions": "pos_embed",
    },
    blocks=(("blocks.", NORM_EPS),),
    block_layers=TIMM_BLOCK | {"gain1": ("ls1.gamma",), "gain2": ("ls2.gamma",)},
    time_bins=TIME_BIN_COUNT,
    image=(320, 240),
    norm_eps=NORM_EPS,
    constants={
        "pos_embed.frequency_bands": lambda width: sinusoid_frequencies(width).expand(3, -1)
    },
)
"""Sparsh trained by V-JEPA; the .safetensors file or the training checkpoint."""
