"""InternViT-300M (OpenGVLab/InternVL): a vision encoder of pictures, frame by frame."""

from __future__ import annotations

from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import (
    TIMM_BLOCK,
    Adapter,
    Asked,
    Names,
    bin_means,
    block_count,
    block_names,
    square_grid,
)
from geotlm_lm.backbone.image_vit import ImageViT, ImageViTConfig
from geotlm_lm.backbone.pixels import (
    IMAGENET,
    Size,
    four_frames,
    normalised,
    resized,
    rounded,
    to_unit,
)
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.weights import without_prefix
from geotlm_lm.core.clip import Clip

NORM_EPS = 1e-6
STEM = "embeddings.patch_embedding.weight"
POSITIONS = "embeddings.position_embedding"
FIRST_MLP = "encoder.layers.0.mlp.fc1.weight"
FIRST_QKV = "encoder.layers.0.attn.qkv.weight"


class InternViT(Adapter):
    """The vision-only reference; on its own, or as the vision part of an InternVL model."""

    name = "internvit"
    title = "InternViT-300M"
    source = "https://huggingface.co/OpenGVLab/InternViT-300M-448px (model.safetensors)"
    mark = (FIRST_QKV, 2)
    anchors = {STEM: 4, POSITIONS: 3, FIRST_MLP: 2, FIRST_QKV: 2}
    released_heads = {1024: 16}

    def select(self, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Keep the vision part."""
        if any(name.startswith("vision_model.") for name in tensors):
            return without_prefix(tensors, "vision_model.")
        return dict(tensors)

    def build(self, found: dict[str, Tensor], asked: Asked) -> tuple[ImageViT, Size]:
        """Size the module; positions may be resized, so that the image's size is free."""
        width, patch = len(found[STEM]), tuple(found[STEM].shape[2:])
        stored = Asked(asked.path, asked.heads)
        grid = square_grid(self, stored, found[POSITIONS].shape[1] - 1, patch)
        config = ImageViTConfig(
            width=width,
            heads=self.heads(width, asked),
            mlp_width=len(found[FIRST_MLP]),
            block_eps=(NORM_EPS,) * block_count(found, "encoder.layers."),
            patch=patch,
            grid=grid,
            has_layer_scale=True,
            resizes_positions=True,
        )
        image = asked.image or (grid[1] * patch[0], grid[2] * patch[1])
        return ImageViT(config), image

    def names(self, module: ImageViT) -> Names:
        """Map InternVL's names."""
        names: Names = {
            "global_token": ("embeddings.class_embedding",),
            "positions": (POSITIONS,),
            "patch.weight": (STEM,),
            "patch.bias": ("embeddings.patch_embedding.bias",),
        }
        for index in range(len(module.blocks)):
            theirs = f"encoder.layers.{index}."
            names |= block_names(f"blocks.{index}.", theirs, TIMM_BLOCK)
            for gain in (1, 2):
                names[f"blocks.{index}.gain{gain}"] = (f"{theirs}ls{gain}",)
        return names

    def pixels(self, clip: Clip, image: Size) -> Tensor:
        """Return (4, 3, rows, columns): whole pictures, resized by bicubic interpolation."""
        frames = rounded(resized(to_unit(four_frames(clip)), image, "bicubic"))
        return normalised(frames, IMAGENET)

    def tokens(self, module: ImageViT, pixels: Tensor) -> Tokens:
        """Return tokens of clips (b, 4, 3, rows, columns): means over the frames of a bin."""
        b, patch = len(pixels), module.config.patch
        grid = (1, pixels.shape[-2] // patch[0], pixels.shape[-1] // patch[1])
        tokens = module(pixels.flatten(0, 1))
        patches = module.patch_grid(tokens, grid)[:, 0].unflatten(0, (b, -1))
        return Tokens(tokens[:, 0].unflatten(0, (b, -1)).mean(dim=1), bin_means(patches))
