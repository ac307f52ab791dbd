"""AnyTouch 2 (GeWu-Lab/AnyTouch2): CLIP blocks over tubes of two frames, with sensor tokens."""

from __future__ import annotations

import torch
from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import (
    CLIP_BLOCK,
    Adapter,
    Asked,
    Names,
    block_count,
    block_names,
    square_grid,
)
from geotlm_lm.backbone.image_vit import ImageViT, ImageViTConfig
from geotlm_lm.backbone.pixels import (
    CLIP_STATISTICS,
    Size,
    background,
    four_frames,
    normalised,
    resized,
    to_unit,
)
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.weights import without_prefix
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import TIME_BIN_COUNT

GELSIGHT_MINI = 3
"""Row of the sensor tokens, in AnyTouch 1 and 2 alike."""

NORM_EPS = 1e-5
IDLE_LEVEL = 130 / 255
"""What an unchanged pixel becomes once the idle gel is subtracted."""

STEM = "touch_model.embeddings.patch_embedding.weight"
POSITIONS = "touch_model.embeddings.position_embedding.weight"
SENSORS = "sensor_token"
FIRST_MLP = "touch_model.encoder.layers.0.mlp.fc1.weight"
PROJECTION = "touch_projection.weight"

PREFIXES = ("touch_mae_model.", "tactile_model.")
BYSTANDERS = ("decoder", "mask_token", "position_ids")
"""Parts of a name that the authors' loading leaves out, or drops as no weight."""


class AnyTouch2(Adapter):
    """The backbone of the paper; give `checkpoint-4frames.pth`."""

    name = "anytouch2"
    title = "AnyTouch 2"
    source = "https://huggingface.co/xxuan01/AnyTouch2-Model (checkpoint-4frames.pth)"
    mark = (STEM, 5)
    anchors = {STEM: 5, POSITIONS: 2, SENSORS: 3, FIRST_MLP: 2, PROJECTION: 2}
    released_heads = {768: 12}

    def select(self, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Strip the prefix and leave decoders, mask tokens and index tables out."""
        for prefix in PREFIXES:
            if any(name.startswith(prefix) for name in tensors):
                tensors = without_prefix(tensors, prefix)
        return {
            name: value
            for name, value in tensors.items()
            if not any(part in name for part in BYSTANDERS)
        }

    def build(self, found: dict[str, Tensor], asked: Asked) -> tuple[ImageViT, Size]:
        """Size the module; a checkpoint of two frames has one time-bin and is refused."""
        patch = tuple(found[STEM].shape[2:])
        grid = square_grid(self, asked, len(found[POSITIONS]) - 1, patch[1:], TIME_BIN_COUNT)
        module = ImageViT(clip_config(self, found, asked, patch, grid))
        return module, (grid[1] * patch[1], grid[2] * patch[2])

    def names(self, module: ImageViT) -> Names:
        """Map CLIP's names."""
        return clip_names(module) | {"patch.weight": (STEM,)}

    def pixels(self, clip: Clip, image: Size) -> Tensor:
        """Return (4, 3, rows, columns), oldest first: difference from the idle gel, CLIP's scale.

        The difference is taken at the camera's size, before resizing.
        """
        difference = to_unit(four_frames(clip)) - to_unit(background(clip)) + IDLE_LEVEL
        return normalised(resized(difference.clamp(0, 1), image), CLIP_STATISTICS)

    def tokens(self, module: ImageViT, pixels: Tensor) -> Tokens:
        """Return tokens of clips (b, 4, 3, rows, columns) as they leave the last block."""
        tokens = module(pixels.transpose(1, 2), sensor_rows(pixels))
        return Tokens(tokens[:, 0], module.patch_grid(tokens))


def clip_config(
    adapter: Adapter, found: dict[str, Tensor], asked: Asked, patch: tuple, grid: tuple
) -> ImageViTConfig:
    """Return the configuration AnyTouch 1 and 2 share, of the sizes found."""
    width = found[POSITIONS].shape[1]
    return ImageViTConfig(
        width=width,
        heads=adapter.heads(width, asked),
        mlp_width=len(found[FIRST_MLP]),
        block_eps=(NORM_EPS,) * block_count(found, "touch_model.encoder.layers."),
        patch=patch,
        grid=grid,
        has_patch_bias=False,
        sensor_rows=found[SENSORS].shape[0],
        sensor_tokens=found[SENSORS].shape[1],
        pre_norm_eps=NORM_EPS,
        norm_eps=NORM_EPS,
        projection=len(found[PROJECTION]),
    )


def clip_names(module: ImageViT) -> Names:
    """Return where the tensors of AnyTouch 1 and 2 go, all but the stem's."""
    names: Names = {
        "global_token": ("touch_model.embeddings.class_embedding",),
        "sensor_tokens": (SENSORS,),
        "positions": (POSITIONS,),
        "projection.weight": (PROJECTION,),
    }
    for kind in ("weight", "bias"):
        names[f"pre_norm.{kind}"] = (f"touch_model.pre_layrnorm.{kind}",)  # spelled like that
        names[f"norm.{kind}"] = (f"touch_model.post_layernorm.{kind}",)
    for index in range(len(module.blocks)):
        theirs = f"touch_model.encoder.layers.{index}."
        names |= block_names(f"blocks.{index}.", theirs, CLIP_BLOCK)
    return names


def sensor_rows(pixels: Tensor) -> Tensor:
    """Return the row of GelSight Mini's tokens for every clip."""
    return torch.full((len(pixels),), GELSIGHT_MINI, device=pixels.device)
