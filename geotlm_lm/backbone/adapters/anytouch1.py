"""AnyTouch 1 (GeWu-Lab/AnyTouch): CLIP blocks over three frames read as one tube."""

from __future__ import annotations

import torch
from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import Adapter, Asked, Names, square_grid
from geotlm_lm.backbone.adapters.anytouch2 import (
    FIRST_MLP,
    POSITIONS,
    PROJECTION,
    SENSORS,
    STEM,
    clip_config,
    clip_names,
    sensor_rows,
)
from geotlm_lm.backbone.image_vit import ImageViT
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

VIDEO_STEM = "video_patch_embedding.weight"
STALE_STEM = STEM
"""CLIP's own stem: still in the file, but the encoder was trained with the other one."""

BIN_FRAMES = ((0, 1, 1), (2, 3, 3))
"""Frames of each time-bin. The encoder reads three, a bin has two, so that the last is repeated: a
bin sees its own frames only, and both in the same arrangement."""


class AnyTouch1(Adapter):
    """The first AnyTouch; the clip is encoded once per time-bin."""

    name = "anytouch1"
    title = "AnyTouch 1"
    source = "https://github.com/GeWu-Lab/AnyTouch (checkpoint.pth, linked from the README)"
    mark = (VIDEO_STEM, 5)
    anchors = {VIDEO_STEM: 5, POSITIONS: 2, SENSORS: 3, FIRST_MLP: 2, PROJECTION: 2}
    released_heads = {1024: 16}

    def select(self, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Keep the touch tower, its projection, the sensor tokens and the video stem."""
        if any(name.startswith("touch_mae_model.") for name in tensors):
            tensors = without_prefix(tensors, "touch_mae_model.")
        kept = ("touch_model.", "touch_projection.")
        return {
            name: value
            for name, value in tensors.items()
            if name in (VIDEO_STEM, SENSORS)
            or (name.startswith(kept) and name != STALE_STEM and "position_ids" not in name)
        }

    def build(self, found: dict[str, Tensor], asked: Asked) -> tuple[ImageViT, Size]:
        """Size the module."""
        patch = tuple(found[VIDEO_STEM].shape[2:])
        grid = square_grid(self, asked, len(found[POSITIONS]) - 1, patch[1:])
        module = ImageViT(clip_config(self, found, asked, patch, grid))
        return module, (grid[1] * patch[1], grid[2] * patch[2])

    def names(self, module: ImageViT) -> Names:
        """Map CLIP's names, and the stem to the one the encoder was trained with."""
        return clip_names(module) | {"patch.weight": (VIDEO_STEM,)}

    def pixels(self, clip: Clip, image: Size) -> Tensor:
        """Return (4, 3, rows, columns): whole pictures, no background taken away."""
        frames = rounded(resized(to_unit(four_frames(clip)), image))
        return normalised(frames, IMAGENET)

    def tokens(self, module: ImageViT, pixels: Tensor) -> Tokens:
        """Return tokens of clips (b, 4, 3, rows, columns); the global token is the bins' mean.

        The stem's first axis is time and its depth is colour: that is how it was trained.
        """
        bins = [module(pixels[:, frames], sensor_rows(pixels)) for frames in BIN_FRAMES]
        global_token = torch.stack([tokens[:, 0] for tokens in bins]).mean(dim=0)
        return Tokens(global_token, torch.cat([module.patch_grid(tokens) for tokens in bins], 1))
