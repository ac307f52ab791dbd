"""AnyTouch 1 and 2 (GeWu-Lab): CLIP blocks over tubes of frames, with tokens of the sensor."""

from __future__ import annotations

import torch
from torch import Tensor

from geotlm_lm.backbone.adapters.vit_adapter import CLIP_BLOCK, ViTAdapter
from geotlm_lm.backbone.image_vit import ImageViT
from geotlm_lm.backbone.pixels import (
    CLIP_STATISTICS,
    IMAGENET,
    Size,
    background,
    four_frames,
    normalised,
    resized,
    rounded,
    to_unit,
)
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import TIME_BIN_COUNT

GELSIGHT_MINI = 3
"""Row of the sensor tokens, in AnyTouch 1 and 2 alike."""

IDLE_LEVEL = 130 / 255
"""What an unchanged pixel becomes once the idle gel is subtracted."""

BIN_FRAMES = ((0, 1, 1), (2, 3, 3))
"""Frames of each time-bin of AnyTouch 1. It reads three, a bin has two, so that the last is
repeated: a bin sees its own frames only, and both in the same arrangement."""

STEM, VIDEO_STEM = "touch_model.embeddings.patch_embedding", "video_patch_embedding"
"""AnyTouch 1 keeps CLIP's own stem in the file, but was trained with the other one."""

WEIGHTS = {
    "global_token": "touch_model.embeddings.class_embedding",
    "sensor_tokens": "sensor_token",
    "positions": "touch_model.embeddings.position_embedding.weight",
    "pre_norm": "touch_model.pre_layrnorm",  # spelled like that
    "norm": "touch_model.post_layernorm",
    "projection": "touch_projection",
}
BLOCKS = "touch_model.encoder.layers."
NORM_EPS = 1e-5
SHARED_ANCHORS = {
    WEIGHTS["positions"]: 2,
    WEIGHTS["sensor_tokens"]: 3,
    f"{BLOCKS}0.mlp.fc1.weight": 2,
    f"{WEIGHTS['projection']}.weight": 2,
}


def clip_difference(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, rows, columns), oldest first: difference from the idle gel, CLIP's scale.

    The difference is taken at the camera's size, before resizing.
    """
    difference = to_unit(four_frames(clip)) - to_unit(background(clip)) + IDLE_LEVEL
    return normalised(resized(difference.clamp(0, 1), image), CLIP_STATISTICS)


def whole_frames(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, rows, columns): whole pictures, no background taken away."""
    frames = rounded(resized(to_unit(four_frames(clip)), image))
    return normalised(frames, IMAGENET)


def tube_tokens(module: ImageViT, pixels: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns) as they leave the last block."""
    tokens = module(pixels.transpose(1, 2), sensor_rows(pixels))
    return Tokens(tokens[:, 0], module.patch_grid(tokens))


def three_frame_tokens(module: ImageViT, pixels: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns); the global token is the bins' mean.

    The stem's first axis is time and its depth is colour: that is how it was trained.
    """
    bins = [module(pixels[:, frames], sensor_rows(pixels)) for frames in BIN_FRAMES]
    global_token = torch.stack([tokens[:, 0] for tokens in bins]).mean(dim=0)
    return Tokens(global_token, torch.cat([module.patch_grid(tokens) for tokens in bins], 1))


def sensor_rows(pixels: Tensor) -> Tensor:
    """Return the row of GelSight Mini's tokens for every clip."""
    return torch.full((len(pixels),), GELSIGHT_MINI, device=pixels.device)


ANYTOUCH2 = ViTAdapter(
    name="anytouch2",
    title="AnyTouch 2",
    source="https://huggingface.co/xxuan01/AnyTouch2-Model (checkpoint-4frames.pth)",
    marks=({f"{STEM}.weight": 5},),
    anchors={f"{STEM}.weight": 5, **SHARED_ANCHORS},
    pixels=clip_difference,
    tokens=tube_tokens,
    prefixes=("touch_mae_model.", "tactile_model."),
    # What the authors' loading leaves out, or drops as no weight.
    dropped=("decoder", "mask_token", "position_ids"),
    released_heads={768: 12},
    weights=WEIGHTS | {"patch": STEM},
    blocks=((BLOCKS, NORM_EPS),),
    block_layers=CLIP_BLOCK,
    time_bins=TIME_BIN_COUNT,
    has_patch_bias=False,
    pre_norm_eps=NORM_EPS,
    norm_eps=NORM_EPS,
)
"""The backbone of the paper: tubes of two frames. A file of two frames has one bin: refused."""

ANYTOUCH1 = ViTAdapter(
    name="anytouch1",
    title="AnyTouch 1",
    source="https://github.com/GeWu-Lab/AnyTouch (checkpoint.pth, linked from the README)",
    marks=({f"{VIDEO_STEM}.weight": 5},),
    anchors={f"{VIDEO_STEM}.weight": 5, **SHARED_ANCHORS},
    pixels=whole_frames,
    tokens=three_frame_tokens,
    prefixes=("touch_mae_model.",),
    kept=("touch_model.", "touch_projection.", "sensor_token", f"{VIDEO_STEM}.weight"),
    dropped=(f"{STEM}.weight", "position_ids"),
    released_heads={1024: 16},
    weights=WEIGHTS | {"patch": VIDEO_STEM},
    blocks=((BLOCKS, NORM_EPS),),
    block_layers=CLIP_BLOCK,
    has_patch_bias=False,
    pre_norm_eps=NORM_EPS,
    norm_eps=NORM_EPS,
)
"""The first AnyTouch: a tube of three frames, so that a clip is encoded once per time-bin."""
