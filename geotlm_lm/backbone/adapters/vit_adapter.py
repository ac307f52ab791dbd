"""Released vision transformers: a table of their names and settings each, one module for all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import torch
from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import (
    Adapter,
    LoadOptions,
    Names,
    Tensors,
    bin_means,
    block_count,
)
from geotlm_lm.backbone.image_vit import ImageViT, ImageViTConfig
from geotlm_lm.backbone.pixels import Size
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.errors import IncompatibleWeights

CLIP_BLOCK: Names = {
    "norm1": ("layer_norm1",),
    "qkv": ("self_attn.q_proj", "self_attn.k_proj", "self_attn.v_proj"),
    "proj": ("self_attn.out_proj",),
    "norm2": ("layer_norm2",),
    "fc1": ("mlp.fc1",),
    "fc2": ("mlp.fc2",),
}
"""Layers of a block as transformers' CLIP names them."""

TIMM_BLOCK: Names = {
    "norm1": ("norm1",),
    "qkv": ("attn.qkv",),
    "proj": ("attn.proj",),
    "norm2": ("norm2",),
    "fc1": ("mlp.fc1",),
    "fc2": ("mlp.fc2",),
}
"""Layers of a block as timm and DINOv2 name them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ViTAdapter(Adapter):
    """A released transformer.

    Args:
        weights: Our name of a part outside of the blocks -> the authors'. Parts a file may lack
            are named like the others.
        blocks: What stands before the number of a block and its norms' epsilon, per stage.
        block_layers: The authors' names of a block's layers; with gains, it has a LayerScale.
        time_bins: Time-bins of the learned positions.
        image: Rows and columns of the authors' images, where positions do not tell them.
        resizes_positions: Whether learned positions are resized to images of another size.
        has_patch_bias: Whether the stem adds a bias.
        pre_norm_eps: Epsilon of a norm before the blocks; None for no norm.
        norm_eps: Epsilon of a norm after the blocks; None for no norm.
        constants: Tables that are no weights -> what they must be at a width.
    """

    weights: Mapping[str, str]
    blocks: tuple[tuple[str, float], ...]
    block_layers: Names
    time_bins: int = 1
    image: Size | None = None
    resizes_positions: bool = False
    has_patch_bias: bool = True
    pre_norm_eps: float | None = None
    norm_eps: float | None = None
    constants: Mapping[str, Callable[[int], Tensor]] = field(default_factory=dict)

    def build(self, found: Tensors, options: LoadOptions) -> tuple[ImageViT, Size]:
        """Size the module."""
        width, *_, rows, columns = (stem := found[f"{self.weights['patch']}.weight"]).shape
        first_mlp = f"{self.blocks[0][0]}0.{self.block_layers['fc1'][0]}.weight"
        grid = self._grid(found, options, (rows, columns))
        sensors = found[self.weights["sensor_tokens"]] if "sensor_tokens" in self.weights else None
        registers = found.get(self.weights.get("registers", ""))
        projection = f"{self.weights.get('projection')}.weight"
        config = ImageViTConfig(
            width=width,
            heads=self.heads(width, options),
            mlp_width=len(found[first_mlp]),
            block_eps=tuple(
                eps for prefix, eps in self.blocks for _ in range(block_count(found, prefix))
            ),
            patch=tuple(stem.shape[2:]),
            grid=grid,
            has_patch_bias=self.has_patch_bias,
            has_layer_scale="gain1" in self.block_layers,
            has_global=self._has_global,
            sensor_rows=0 if sensors is None else sensors.shape[0],
            sensor_tokens=0 if sensors is None else sensors.shape[1],
            registers=0 if registers is None else registers.shape[-2],
            has_sinusoids=self.weights["positions"] not in found,
            resizes_positions=self.resizes_positions,
            pre_norm_eps=self.pre_norm_eps,
            norm_eps=self.norm_eps,
            projection=len(found[projection]) if projection in found else 0,
        )
        own_size = (grid[1] * rows, grid[2] * columns)
        return ImageViT(config), (self.resizes_positions and options.image) or own_size

    @property
    def _has_global(self) -> bool:
        return "global_token" in self.weights

    def _grid(self, found: Tensors, options: LoadOptions, patch: Size) -> tuple[int, int, int]:
        """Return (bins, rows, columns) of the positions.

        Raises:
            IncompatibleWeights: If learned positions do not fill such a grid.
        """
        image = None if self.resizes_positions else options.image or self.image
        positions = found.get(self.weights["positions"])
        # Positions of an unknown image are of a square one.
        count = None if positions is None else positions.shape[-2] - self._has_global
        side = math.isqrt((count or 0) // self.time_bins)
        rows, columns = (side, side) if image is None else map(int.__floordiv__, image, patch)
        if count not in (None, self.time_bins * rows * columns):
            size = "a square image" if image is None else f"{image[0]}x{image[1]} pixels"
            raise IncompatibleWeights(
                f"{options.path}: {count} positions, expected {self.time_bins} times a grid of "
                f"{size} for {self.title}; get the file for such images from {self.source}."
            )
        return self.time_bins, rows, columns

    def names(self, module: ImageViT, found: Tensors) -> Names:
        """Map every weight by the table."""
        prefixes = [
            f"{prefix}{number}."
            for prefix, _ in self.blocks
            for number in range(block_count(found, prefix))
        ]
        names: Names = {}
        for ours in module.state_dict():
            part, *kind = ours.split(".")
            theirs = (self.weights.get(part, ""),)
            if part == "blocks":
                index, layer, *kind = kind
                theirs = tuple(prefixes[int(index)] + one for one in self.block_layers[layer])
            names[ours] = tuple(".".join([one, *kind]) for one in theirs)
        return names

    def checked(self, found: Tensors, options: LoadOptions) -> Tensors:
        """Return `found` without constants, once they are known to be the released ones."""
        weights = {name: value for name, value in found.items() if name not in self.constants}
        stem = found.get(f"{self.weights['patch']}.weight")
        for name in found.keys() & self.constants.keys() if stem is not None else ():
            table, ours = found[name], self.constants[name](len(stem))
            if table.shape != ours.shape or not torch.allclose(table.float(), ours, rtol=1e-5):
                raise IncompatibleWeights(
                    f"{options.path}: {name} is not the table {self.title} was released with; get "
                    f"the file from {self.source}."
                )
        return weights


def frame_tokens(module: ImageViT, pixels: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns) seen frame by frame: means over a bin's."""
    b, patch = len(pixels), module.config.patch
    grid = (1, pixels.shape[-2] // patch[0], pixels.shape[-1] // patch[1])
    tokens = module.normed(module(pixels.flatten(0, 1)))
    patches = module.patch_grid(tokens, grid)[:, 0].unflatten(0, (b, -1))
    return Tokens(tokens[:, 0].unflatten(0, (b, -1)).mean(dim=1), bin_means(patches))
