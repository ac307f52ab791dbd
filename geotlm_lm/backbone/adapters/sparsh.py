"""Sparsh V-JEPA (facebookresearch/sparsh): tubes of two frames, newest first, no global token."""

from __future__ import annotations

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import (
    TIMM_BLOCK,
    Adapter,
    Asked,
    Names,
    block_count,
    block_names,
    square_grid,
)
from geotlm_lm.backbone.image_vit import ImageViT, ImageViTConfig, sinusoid_frequencies
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
from geotlm_lm.backbone.weights import without_prefix
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights, UnreadableClip
from geotlm_lm.core.geometry import TIME_BIN_COUNT

NORM_EPS = 1e-6
IMAGE: Size = (320, 240)
ASPECT = 4 / 3
"""Columns over rows of a picture of which the authors cut nothing."""

STEM = "patch_embed.proj.weight"
FIRST_MLP = "blocks.0.mlp.fc1.weight"
FIRST_GAIN = "blocks.0.ls1.gamma"
FREQUENCIES = "pos_embed.frequency_bands"
POSITIONS = "pos_embed"
REGISTERS = "register_tokens"
PREFIXES = ("target_encoder.", "backbone.")
"""What stands before the encoder's names in a training checkpoint; the context encoder beside it
has the same names and other numbers."""


class Sparsh(Adapter):
    """Sparsh trained by V-JEPA; the .safetensors file or the training checkpoint."""

    name = "sparsh"
    title = "Sparsh V-JEPA"
    source = "https://huggingface.co/facebook/sparsh-vjepa-base (vjepa_vitbase.safetensors)"
    mark = (STEM, 5)
    anchors = {STEM: 5, FIRST_MLP: 2, FIRST_GAIN: 1}
    released_heads = {768: 12}

    def select(self, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Keep the target encoder."""
        for prefix in PREFIXES:
            if any(name.startswith(prefix) for name in tensors):
                tensors = without_prefix(tensors, prefix)
        return dict(tensors)

    def build(self, found: dict[str, Tensor], asked: Asked) -> tuple[ImageViT, Size]:
        """Size the module; positions are computed unless the file holds learned ones."""
        width = len(found[STEM])
        patch = tuple(found[STEM].shape[2:])
        image = asked.image or IMAGE
        grid = (TIME_BIN_COUNT, image[0] // patch[1], image[1] // patch[2])
        has_sinusoids = POSITIONS not in found
        if not has_sinusoids:
            sized = Asked(asked.path, asked.heads, image)
            count = found[POSITIONS].shape[-2]
            grid = square_grid(self, sized, count, patch[1:], TIME_BIN_COUNT)
        config = ImageViTConfig(
            width=width,
            heads=self.heads(width, asked),
            mlp_width=len(found[FIRST_MLP]),
            block_eps=(NORM_EPS,) * block_count(found, "blocks."),
            patch=patch,
            grid=grid,
            has_layer_scale=True,
            has_global=False,
            registers=found[REGISTERS].shape[-2] if REGISTERS in found else 0,
            has_sinusoids=has_sinusoids,
            norm_eps=NORM_EPS,
        )
        return ImageViT(config), (grid[1] * patch[1], grid[2] * patch[2])

    def checked(self, found: dict[str, Tensor], asked: Asked) -> dict[str, Tensor]:
        """Return `found` without the table of frequencies, which must be the released one."""
        table = found.pop(FREQUENCIES, None)
        if table is None or STEM not in found:
            return found
        ours = sinusoid_frequencies(len(found[STEM])).expand(3, -1)
        if table.shape != ours.shape or not torch.allclose(table.float(), ours, rtol=1e-5):
            raise IncompatibleWeights(
                f"{asked.path}: {FREQUENCIES} is not the table {self.title} was released with; get "
                f"the file from {self.source}."
            )
        return found

    def names(self, module: ImageViT) -> Names:
        """Map DINOv2's names."""
        names: Names = {}
        for kind in ("weight", "bias"):
            names[f"patch.{kind}"] = (f"patch_embed.proj.{kind}",)
            names[f"norm.{kind}"] = (f"norm.{kind}",)
        if module.registers is not None:
            names["registers"] = (REGISTERS,)
        if module.positions is not None:
            names["positions"] = (POSITIONS,)
        for index in range(len(module.blocks)):
            names |= block_names(f"blocks.{index}.", f"blocks.{index}.", TIMM_BLOCK)
            for gain in (1, 2):
                names[f"blocks.{index}.gain{gain}"] = (f"blocks.{index}.ls{gain}.gamma",)
        return names

    def pixels(self, clip: Clip, image: Size) -> Tensor:
        """Return (3, 4, rows, columns) in [0, 1], newest frame first, landscape pictures upright.

        The authors turn landscape pictures by 90 degrees clockwise; `tokens` turns the grid back.
        Others they leave as they are, which would give a grid of another shape: a portrait picture
        that comes turned counterclockwise is seen as they show it.

        Raises:
            UnreadableClip: If the picture is not wider than high.
        """
        idle = unsquashed(background(clip))
        rows, columns = idle.shape[:2]
        if columns <= rows:
            raise UnreadableClip(
                f"{clip.name}: frames are {columns}x{rows} pixels, {self.title} reads pictures "
                f"wider than high; turn the recording by 90 degrees counterclockwise, or export "
                f"all of the camera's picture."
            )
        frames = [_upright(_difference(unsquashed(f), idle)) for f in four_frames(clip)[::-1]]
        return rounded(resized(to_unit(np.stack(frames)), image)).transpose(0, 1)

    def tokens(self, module: ImageViT, pixels: Tensor) -> Tokens:
        """Return tokens of clips (b, 3, 4, rows, columns), early bin first, rows as in the camera.

        There is no global token: the mean over the patches stands for it.
        """
        grid = module.patch_grid(module.normed(module(pixels)))
        mean = grid.flatten(1, 3).mean(dim=1)
        return Tokens(mean, torch.rot90(grid.flip(1), 1, dims=(2, 3)))

    def view(self, clip: Clip) -> View | None:
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
