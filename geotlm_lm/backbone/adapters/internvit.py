"""InternViT-300M (OpenGVLab/InternVL): a vision encoder of pictures, frame by frame."""

from __future__ import annotations

from torch import Tensor

from geotlm_lm.backbone.adapters.vit_adapter import TIMM_BLOCK, ViTAdapter, frame_tokens
from geotlm_lm.backbone.pixels import (
    IMAGENET,
    Size,
    four_frames,
    normalised,
    resized,
    rounded,
    to_unit,
)
from geotlm_lm.core.clip import Clip

FIRST_QKV = "encoder.layers.0.attn.qkv.weight"


def whole_frames(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, rows, columns): whole pictures, resized by bicubic interpolation."""
    frames = rounded(resized(to_unit(four_frames(clip)), image, "bicubic"))
    return normalised(frames, IMAGENET)


INTERNVIT = ViTAdapter(
    name="internvit",
    title="InternViT-300M",
    source="https://huggingface.co/OpenGVLab/InternViT-300M-448px (model.safetensors)",
    marks=({FIRST_QKV: 2},),
    anchors={
        "embeddings.patch_embedding.weight": 4,
        "embeddings.position_embedding": 3,
        "encoder.layers.0.mlp.fc1.weight": 2,
        FIRST_QKV: 2,
    },
    pixels=whole_frames,
    tokens=frame_tokens,
    prefixes=("vision_model.",),
    released_heads={1024: 16},
    weights={
        "global_token": "embeddings.class_embedding",
        "positions": "embeddings.position_embedding",
        "patch": "embeddings.patch_embedding",
    },
    blocks=(("encoder.layers.", 1e-6),),
    block_layers=TIMM_BLOCK | {"gain1": ("ls1",), "gain2": ("ls2",)},
    resizes_positions=True,
)
"""The vision-only reference; on its own, or as the vision part of an InternVL model."""
