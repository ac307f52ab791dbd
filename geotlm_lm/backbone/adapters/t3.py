"""T3 (alanzjl/t3): an encoder per sensor and a trunk for all, frame by frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import Axes, Tensors, has_axes
from geotlm_lm.backbone.adapters.vit_adapter import TIMM_BLOCK, ViTAdapter, frame_tokens
from geotlm_lm.backbone.pixels import (
    IMAGENET,
    Size,
    four_frames,
    normalised,
    rounded,
    to_unit,
    unsquashed,
)
from geotlm_lm.backbone.view import View
from geotlm_lm.backbone.weights import read_tensors
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights
from geotlm_lm.core.geometry import IMAGE_SIDE

SOURCE = (
    "https://huggingface.co/datasets/alanz-mit/FoundationTactile "
    "(models/t3_medium: encoders/mini.pth and trunk.pth)"
)
ENCODER_EPS, TRUNK_EPS = 1e-6, 1e-5
CUT = 224 / 256
"""Side of the square that is cut from the middle, over the picture's shorter side."""

TRUNK_FILE = "trunk.pth"
STEM = "patch_embed.proj.weight"
ENCODER_MARK: Axes = {STEM: 4, "pos_embed": 3, "cls_token": 3}
TRUNK_MARK: Axes = {"blocks.0.attn.qkv.weight": 2, "norm.weight": 1, STEM: None}


def with_trunk(path: Path, tensors: Tensors) -> Tensors:
    """Add the trunk's tensors to a sensor's encoder, and tell both apart by a prefix.

    Raises:
        IncompatibleWeights: If the encoder has no trunk beside it, or this is the trunk.
    """
    if has_axes(tensors, TRUNK_MARK):
        raise IncompatibleWeights(
            f"{path}: is T3's trunk, expected the encoder of a sensor; give that file, "
            f"encoders/mini.pth for GelSight Mini, and leave the trunk beside its folder."
        )
    parts = {f"encoder.{name}": value for name, value in tensors.items()}
    if not has_axes(tensors, ENCODER_MARK):
        return parts  # what is missing of the encoder is told first
    places = [folder / TRUNK_FILE for folder in (path.parent, path.parent.parent)]
    trunk = next((place for place in places if place.is_file()), None)
    if trunk is None:
        raise IncompatibleWeights(
            f"{path}: T3's encoder was found without its trunk, expected {TRUNK_FILE} beside "
            f"it or one folder up; get both from {SOURCE}."
        )
    return parts | {f"trunk.{name}": value for name, value in read_tensors(trunk).items()}


def middle_frames(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, side, side): the middle of whole pictures, ImageNet's mean and deviation.

    The authors normalise by each data set's own statistics and by ImageNet's where there are none;
    a recording of yours has none.
    """
    frames = [unsquashed(frame) for frame in four_frames(clip)]
    return normalised(_middle(frames, image), IMAGENET)


def middle_view(clip: Clip) -> View | None:
    """Return the square that is read; None where it is none in the squashed image."""
    rows, columns = unsquashed(clip.frames[0]).shape[:2]
    return View(side_px=IMAGE_SIDE * CUT) if rows == columns else None


def _middle(frames: list[NDArray[np.uint8]], image: Size) -> Tensor:
    """Resize the shorter side and cut the middle, as torchvision's Resize and CenterCrop do."""
    images = to_unit(np.stack(frames))
    rows, columns = images.shape[-2:]
    short = round(min(image) / CUT)
    size = (short, int(short * columns / rows)) if rows <= columns else None
    size = size or (int(short * rows / columns), short)
    images = rounded(F.interpolate(images, size=size, mode="bilinear", antialias=True))
    top, left = (round((size[axis] - image[axis]) / 2) for axis in range(2))
    return images[..., top : top + image[0], left : left + image[1]]


T3 = ViTAdapter(
    name="t3",
    title="T3",
    source=SOURCE,
    marks=(ENCODER_MARK, TRUNK_MARK),  # the trunk alone is refused in its own words
    anchors={
        f"encoder.{STEM}": 4,
        "encoder.pos_embed": 3,
        "encoder.blocks.0.mlp.fc1.weight": 2,
        "trunk.norm.weight": 1,
    },
    pixels=middle_frames,
    tokens=frame_tokens,
    view=middle_view,
    complete=with_trunk,
    released_heads={768: 12},
    weights={
        "global_token": "encoder.cls_token",
        "positions": "encoder.pos_embed",
        "patch": "encoder.patch_embed.proj",
        "norm": "trunk.norm",
    },
    blocks=(("encoder.blocks.", ENCODER_EPS), ("trunk.blocks.", TRUNK_EPS)),
    block_layers=TIMM_BLOCK,
    norm_eps=TRUNK_EPS,
)
"""Give the sensor's encoder file: the trunk is found beside it or one folder up."""
