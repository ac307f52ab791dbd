"""The released encoders, one row each: their files, pixels, tokens and parts.

`released` loads a file by its row; the preparation of pixels is in `pixels`, the modules are in
`encoder_modules`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from geotlm_lm.backbone import pixels
from geotlm_lm.backbone.encoder_modules import ConvEncoder, ImageViT, sinusoid_frequencies
from geotlm_lm.backbone.pixels import SPARSH_TITLE, Size
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.backbone.weights import read_tensors
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights
from geotlm_lm.core.geometry import FRAME_COUNT, TIME_BIN_COUNT, TUBE_FRAMES

Tensors = dict[str, Tensor]

Names = Mapping[str, tuple[str, ...]]
"""Our name of a weight -> the authors' names of its parts, joined along the first axis."""

Axes = Mapping[str, int | None]
"""Names of tensors and their numbers of axes; None for a tensor that must be absent."""

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
class EncoderRow:
    """What is known of one released encoder."""

    name: str  # what the command line calls it
    title: str  # what messages call it
    source: str  # where the authors release the file
    marks: tuple[Axes, ...]  # the file is recognised by any one of these sets of tensors
    anchors: Mapping[str, int]  # tensors whose sizes decide the module's
    # The authors' preparation of one clip of four frames at a size.
    pixels: Callable[[Clip, Size], Tensor]
    # Their forward pass over a batch of such pixels, cut to what DGR reads.
    tokens: Callable[[nn.Module, Tensor], Tokens]
    # The square of the image that the patch grid covers; None where it is no square.
    view: Callable[[Clip], View | None] = lambda clip: View()
    # What is taken off the names in turn; where a file has one, all else is dropped.
    prefixes: tuple[str, ...] = ()
    # The names, or with a dot at the end their beginnings, that belong to the encoder; empty for
    # all.
    kept: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()  # parts of names that do not belong to it
    # Adds the tensors of files that belong to the one at a path.
    complete: Callable[[Path, Tensors], Tensors] = lambda path, tensors: tensors
    # Rows and columns of the authors' images, where positions do not tell them.
    image: Size | None = None
    # Attention heads by width, which no file tells.
    released_heads: Mapping[int, int] = field(default_factory=dict)
    # Our name of a part outside of the blocks -> the authors'. Parts a file may lack are named
    # like the others.
    weights: Mapping[str, str] = field(default_factory=dict)
    # What stands before the number of a block and its norms' epsilon, per stage. Without any the
    # encoder is convolutional, its parts named as the file's.
    blocks: tuple[tuple[str, float], ...] = ()
    # The authors' names of a block's layers; with gains, it has a LayerScale.
    block_layers: Names = field(default_factory=dict)
    time_bins: int = 1  # time-bins of the learned positions
    # Parts of an `ImageViTConfig` that no file tells.
    parts: Mapping[str, Any] = field(default_factory=dict)
    # Tables that are no weights -> what they must be at a width.
    constants: Mapping[str, Callable[[int], Tensor]] = field(default_factory=dict)


def has_axes(tensors: Tensors, wanted: Axes) -> bool:
    """Tell whether all of the `wanted` tensors are there, or absent, with their axes."""
    return all(
        name not in tensors if axes is None else name in tensors and tensors[name].ndim == axes
        for name, axes in wanted.items()
    )


# AnyTouch 1 and 2 (GeWu-Lab): CLIP blocks over tubes of frames, with tokens of the sensor.

GELSIGHT_MINI = 3
"""Row of the sensor tokens, in AnyTouch 1 and 2 alike."""

BIN_FRAMES = ((0, 1, 1), (2, 3, 3))
"""Frames of each time-bin of AnyTouch 1. It reads three, a bin has two, so that the last is
repeated: a bin sees its own frames only, and both in the same arrangement."""

STEM, VIDEO_STEM = "touch_model.embeddings.patch_embedding", "video_patch_embedding"
"""AnyTouch 1 keeps CLIP's own stem in the file, but was trained with the other one."""

TOUCH_WEIGHTS = {
    "global_token": "touch_model.embeddings.class_embedding",
    "sensor_tokens": "sensor_token",
    "positions": "touch_model.embeddings.position_embedding.weight",
    "pre_norm": "touch_model.pre_layrnorm",  # spelled like that
    "norm": "touch_model.post_layernorm",
    "projection": "touch_projection",
}
TOUCH_BLOCKS = "touch_model.encoder.layers."
TOUCH_ANCHORS = {
    TOUCH_WEIGHTS["positions"]: 2,
    TOUCH_WEIGHTS["sensor_tokens"]: 3,
    f"{TOUCH_BLOCKS}0.mlp.fc1.weight": 2,
    f"{TOUCH_WEIGHTS['projection']}.weight": 2,
}


def tube_tokens(module: ImageViT, images: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns) as they leave the last block."""
    tokens = module(images.transpose(1, 2), _sensor_rows(images))
    return Tokens(tokens[:, 0], module.patch_grid(tokens))


def three_frame_tokens(module: ImageViT, images: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns); the global token is the bins' mean.

    The stem's first axis is time and its depth is colour: that is how it was trained.
    """
    bins = [module(images[:, frames], _sensor_rows(images)) for frames in BIN_FRAMES]
    global_token = torch.stack([tokens[:, 0] for tokens in bins]).mean(dim=0)
    return Tokens(global_token, torch.cat([module.patch_grid(tokens) for tokens in bins], 1))


def _sensor_rows(images: Tensor) -> Tensor:
    return torch.full((len(images),), GELSIGHT_MINI, device=images.device)


TOUCH = {
    "blocks": ((TOUCH_BLOCKS, 1e-5),),
    "block_layers": CLIP_BLOCK,
    "parts": {"has_patch_bias": False, "pre_norm_eps": 1e-5, "norm_eps": 1e-5},
}

ANYTOUCH2 = EncoderRow(
    name="anytouch2",
    title="AnyTouch 2",
    source="https://huggingface.co/xxuan01/AnyTouch2-Model (checkpoint-4frames.pth)",
    marks=({f"{STEM}.weight": 5},),
    anchors={f"{STEM}.weight": 5, **TOUCH_ANCHORS},
    pixels=pixels.clip_difference,
    tokens=tube_tokens,
    prefixes=("touch_mae_model.", "tactile_model."),
    # What the authors' loading leaves out, or drops as no weight.
    dropped=("decoder", "mask_token", "position_ids"),
    released_heads={768: 12},
    weights=TOUCH_WEIGHTS | {"patch": STEM},
    time_bins=TIME_BIN_COUNT,
    **TOUCH,
)
"""The backbone of the paper: tubes of two frames. A file of two frames has one bin: refused."""

ANYTOUCH1 = EncoderRow(
    name="anytouch1",
    title="AnyTouch 1",
    source="https://github.com/GeWu-Lab/AnyTouch (checkpoint.pth, linked from the README)",
    marks=({f"{VIDEO_STEM}.weight": 5},),
    anchors={f"{VIDEO_STEM}.weight": 5, **TOUCH_ANCHORS},
    pixels=pixels.whole_frames,
    tokens=three_frame_tokens,
    prefixes=("touch_mae_model.",),
    kept=("touch_model.", "touch_projection.", "sensor_token", f"{VIDEO_STEM}.weight"),
    dropped=(f"{STEM}.weight", "position_ids"),
    released_heads={1024: 16},
    weights=TOUCH_WEIGHTS | {"patch": VIDEO_STEM},
    **TOUCH,
)
"""The first AnyTouch: a tube of three frames, so that a clip is encoded once per time-bin."""


# Sparsh V-JEPA (facebookresearch/sparsh): tubes of two frames, newest first, no global token.


def upright_tokens(module: ImageViT, images: Tensor) -> Tokens:
    """Return tokens of clips (b, 3, 4, rows, columns), early bin first, rows as in the camera.

    There is no global token: the mean over the patches stands for it.
    """
    grid = module.patch_grid(module.normed(module(images)))
    mean = grid.flatten(1, 3).mean(dim=1)
    return Tokens(mean, torch.rot90(grid.flip(1), 1, dims=(2, 3)))


SPARSH = EncoderRow(
    name="sparsh",
    title=SPARSH_TITLE,
    source="https://huggingface.co/facebook/sparsh-vjepa-base (vjepa_vitbase.safetensors)",
    marks=({"patch_embed.proj.weight": 5},),
    anchors={
        "patch_embed.proj.weight": 5,
        "blocks.0.mlp.fc1.weight": 2,
        "blocks.0.ls1.gamma": 1,
    },
    pixels=pixels.upright_difference,
    tokens=upright_tokens,
    view=pixels.uncut_view,
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
    blocks=(("blocks.", 1e-6),),
    block_layers=TIMM_BLOCK | {"gain1": ("ls1.gamma",), "gain2": ("ls2.gamma",)},
    time_bins=TIME_BIN_COUNT,
    image=(320, 240),
    parts={"norm_eps": 1e-6},
    constants={
        "pos_embed.frequency_bands": lambda width: sinusoid_frequencies(width).expand(3, -1)
    },
)
"""Sparsh trained by V-JEPA; the .safetensors file or the training checkpoint."""


# T3 (alanzjl/t3): an encoder per sensor and a trunk for all, frame by frame.

T3_SOURCE = (
    "https://huggingface.co/datasets/alanz-mit/FoundationTactile "
    "(models/t3_medium: encoders/mini.pth and trunk.pth)"
)
TRUNK_FILE = "trunk.pth"
T3_STEM = "patch_embed.proj.weight"
SENSOR_MARK: Axes = {T3_STEM: 4, "pos_embed": 3, "cls_token": 3}
TRUNK_MARK: Axes = {"blocks.0.attn.qkv.weight": 2, "norm.weight": 1, T3_STEM: None}


def with_trunk(path: Path, tensors: Tensors) -> Tensors:
    """Add the trunk's tensors to a sensor's encoder, and tell both apart by a prefix."""
    if has_axes(tensors, TRUNK_MARK):
        raise IncompatibleWeights(
            f"{path}: is T3's trunk, expected the encoder of a sensor; give that file, "
            f"encoders/mini.pth for GelSight Mini, and leave the trunk beside its folder."
        )
    parts = {f"encoder.{name}": value for name, value in tensors.items()}
    if not has_axes(tensors, SENSOR_MARK):
        return parts  # what is missing of the encoder is reported first
    places = [folder / TRUNK_FILE for folder in (path.parent, path.parent.parent)]
    trunk = next((place for place in places if place.is_file()), None)
    if trunk is None:
        raise IncompatibleWeights(
            f"{path}: T3's encoder was found without its trunk, expected {TRUNK_FILE} beside "
            f"it or one folder up; get both from {T3_SOURCE}."
        )
    return parts | {f"trunk.{name}": value for name, value in read_tensors(trunk).items()}


def frame_tokens(module: ImageViT, images: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns) seen frame by frame: means over a bin's."""
    b, patch = len(images), module.config.patch
    grid = (1, images.shape[-2] // patch[0], images.shape[-1] // patch[1])
    tokens = module.normed(module(images.flatten(0, 1)))
    patches = module.patch_grid(tokens, grid)[:, 0].unflatten(0, (b, -1))
    return Tokens(tokens[:, 0].unflatten(0, (b, -1)).mean(dim=1), _bin_means(patches))


def _bin_means(frames: Tensor) -> Tensor:
    return frames.unflatten(1, (FRAME_COUNT // TUBE_FRAMES, TUBE_FRAMES)).mean(dim=2)


T3 = EncoderRow(
    name="t3",
    title="T3",
    source=T3_SOURCE,
    marks=(SENSOR_MARK, TRUNK_MARK),  # the trunk alone is refused in its own words
    anchors={
        f"encoder.{T3_STEM}": 4,
        "encoder.pos_embed": 3,
        "encoder.blocks.0.mlp.fc1.weight": 2,
        "trunk.norm.weight": 1,
    },
    pixels=pixels.middle_frames,
    tokens=frame_tokens,
    view=pixels.middle_view,
    complete=with_trunk,
    released_heads={768: 12},
    weights={
        "global_token": "encoder.cls_token",
        "positions": "encoder.pos_embed",
        "patch": "encoder.patch_embed.proj",
        "norm": "trunk.norm",
    },
    blocks=(("encoder.blocks.", 1e-6), ("trunk.blocks.", 1e-5)),
    block_layers=TIMM_BLOCK,
    parts={"norm_eps": 1e-5},
)
"""Give the sensor's encoder file: the trunk is found beside it or one folder up."""


INTERNVIT = EncoderRow(
    name="internvit",
    title="InternViT-300M",
    source="https://huggingface.co/OpenGVLab/InternViT-300M-448px (model.safetensors)",
    marks=({"encoder.layers.0.attn.qkv.weight": 2},),
    anchors={
        "embeddings.patch_embedding.weight": 4,
        "embeddings.position_embedding": 3,
        "encoder.layers.0.mlp.fc1.weight": 2,
        "encoder.layers.0.attn.qkv.weight": 2,
    },
    pixels=partial(pixels.whole_frames, how="bicubic"),
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
    parts={"resizes_positions": True},
)
"""The vision-only reference; on its own, or as the vision part of an InternVL model."""


def latent_tokens(module: ConvEncoder, images: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns); the global one is the flat latent.

    A mean over the grid would leave three numbers; the authors read the whole grid too.
    """
    latent = module(images.flatten(0, 1)).unflatten(0, (len(images), -1))  # b t d gh gw
    return Tokens(latent.flatten(2).mean(dim=1), _bin_means(latent.movedim(2, -1)))


UNIT = EncoderRow(
    name="unit",
    title="UniT",
    source="https://github.com/ZhengtongXu/UniT (a folder of checkpoints, linked from the README)",
    marks=({"quant_conv.weight": 4},),
    anchors={
        "encoder.conv_in.weight": 4,
        "encoder.down.0.block.0.conv1.weight": 4,
        "encoder.conv_out.weight": 4,
        "quant_conv.weight": 4,
    },
    pixels=pixels.blue_first,
    tokens=latent_tokens,
    kept=("encoder.", "quant_conv."),
    image=(128, 160),
)
"""The convolutional encoder of a VQGAN (ZhengtongXu/UniT), frame by frame: the latent before
quantisation is a grid of tokens three numbers wide."""

ENCODERS: dict[str, EncoderRow] = {
    row.name: row for row in (ANYTOUCH2, ANYTOUCH1, SPARSH, T3, INTERNVIT, UNIT)
}
"""Every released encoder by the name the command line gives it."""
