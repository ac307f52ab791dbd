"""T3 (alanzjl/t3): an encoder per sensor and a trunk for all, frame by frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch.nn.functional as F
from numpy.typing import NDArray
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
    rounded,
    to_unit,
    unsquashed,
)
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.backbone.weights import read_tensors
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights
from geotlm_lm.core.geometry import IMAGE_SIDE

ENCODER_EPS, TRUNK_EPS = 1e-6, 1e-5
CUT = 224 / 256
"""Side of the square that is cut from the middle, over the picture's shorter side."""

TRUNK_FILE = "trunk.pth"
ENCODER, TRUNK = "encoder.", "trunk."
STEM = f"{ENCODER}patch_embed.proj.weight"
POSITIONS = f"{ENCODER}pos_embed"
FIRST_MLP = f"{ENCODER}blocks.0.mlp.fc1.weight"
TRUNK_NORM = f"{TRUNK}norm.weight"


class T3(Adapter):
    """T3; give the sensor's encoder file, the trunk is found beside it or one folder up."""

    name = "t3"
    title = "T3"
    source = (
        "https://huggingface.co/datasets/alanz-mit/FoundationTactile "
        "(models/t3_medium: encoders/mini.pth and trunk.pth)"
    )
    mark = (POSITIONS, 3)
    anchors = {STEM: 4, POSITIONS: 3, FIRST_MLP: 2, TRUNK_NORM: 1}
    released_heads = {768: 12}

    def claims(self, tensors: dict[str, Tensor]) -> bool:
        """Tell T3 by the sensor's encoder, or by the trunk, which alone is refused later."""
        return _is_encoder(tensors) or _is_trunk(tensors)

    def complete(self, path: Path, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Add the trunk's tensors, and tell both apart by a prefix.

        Raises:
            IncompatibleWeights: If the encoder has no trunk beside it, or this is the trunk.
        """
        if _is_trunk(tensors):
            raise IncompatibleWeights(
                f"{path}: is T3's trunk, expected the encoder of a sensor; give that file, "
                f"encoders/mini.pth for GelSight Mini, and leave the trunk beside its folder."
            )
        parts = {f"{ENCODER}{name}": value for name, value in tensors.items()}
        if not _is_encoder(tensors):
            return parts  # what is missing of the encoder is told first
        places = [folder / TRUNK_FILE for folder in (path.parent, path.parent.parent)]
        trunk = next((place for place in places if place.is_file()), None)
        if trunk is None:
            raise IncompatibleWeights(
                f"{path}: T3's encoder was found without its trunk, expected {TRUNK_FILE} beside "
                f"it or one folder up; get both from {self.source}."
            )
        return parts | {f"{TRUNK}{name}": value for name, value in read_tensors(trunk).items()}

    def select(self, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Keep everything: both files hold nothing else."""
        return dict(tensors)

    def build(self, found: dict[str, Tensor], asked: Asked) -> tuple[ImageViT, Size]:
        """Size the module: the trunk's blocks follow the encoder's, with another epsilon."""
        width, patch = len(found[STEM]), tuple(found[STEM].shape[2:])
        grid = square_grid(self, asked, found[POSITIONS].shape[1] - 1, patch)
        before = block_count(found, f"{ENCODER}blocks.")
        after = block_count(found, f"{TRUNK}blocks.")
        config = ImageViTConfig(
            width=width,
            heads=self.heads(width, asked),
            mlp_width=len(found[FIRST_MLP]),
            block_eps=(ENCODER_EPS,) * before + (TRUNK_EPS,) * after,
            patch=patch,
            grid=grid,
            norm_eps=TRUNK_EPS,
        )
        return ImageViT(config), (grid[1] * patch[0], grid[2] * patch[1])

    def names(self, module: ImageViT) -> Names:
        """Map timm's names, the trunk's blocks after the encoder's."""
        names: Names = {
            "global_token": (f"{ENCODER}cls_token",),
            "positions": (POSITIONS,),
            "patch.weight": (STEM,),
            "patch.bias": (f"{ENCODER}patch_embed.proj.bias",),
            "norm.weight": (TRUNK_NORM,),
            "norm.bias": (f"{TRUNK}norm.bias",),
        }
        before = encoder_depth(module)
        for index in range(len(module.blocks)):
            is_encoder = index < before
            prefix, number = (ENCODER, index) if is_encoder else (TRUNK, index - before)
            names |= block_names(f"blocks.{index}.", f"{prefix}blocks.{number}.", TIMM_BLOCK)
        return names

    def pixels(self, clip: Clip, image: Size) -> Tensor:
        """Return (4, 3, side, side): the middle of whole pictures, ImageNet's mean and deviation.

        The authors normalise by each data set's own statistics and by ImageNet's where there are
        none; a recording of yours has none.
        """
        frames = [unsquashed(frame) for frame in four_frames(clip)]
        return normalised(_middle(frames, image), IMAGENET)

    def tokens(self, module: ImageViT, pixels: Tensor) -> Tokens:
        """Return tokens of clips (b, 4, 3, side, side): means over the frames of a bin."""
        b = len(pixels)
        tokens = module.normed(module(pixels.flatten(0, 1)))
        patches = module.patch_grid(tokens)[:, 0].unflatten(0, (b, -1))
        return Tokens(tokens[:, 0].unflatten(0, (b, -1)).mean(dim=1), bin_means(patches))

    def view(self, clip: Clip) -> View | None:
        """Return the square that is read; None where it is none in the squashed image."""
        rows, columns = unsquashed(clip.frames[0]).shape[:2]
        return View(side_px=IMAGE_SIDE * CUT) if rows == columns else None


def _is_encoder(tensors: dict[str, Tensor]) -> bool:
    stem, positions = tensors.get("patch_embed.proj.weight"), tensors.get("pos_embed")
    has_all = stem is not None and positions is not None and "cls_token" in tensors
    return has_all and stem.ndim == 4 and positions.ndim == 3


def _is_trunk(tensors: dict[str, Tensor]) -> bool:
    has_blocks = {"blocks.0.attn.qkv.weight", "norm.weight"} <= tensors.keys()
    return has_blocks and not any(name.startswith("patch_embed.") for name in tensors)


def encoder_depth(module: ImageViT) -> int:
    """Return how many of the blocks are the sensor's own."""
    return module.config.block_eps.count(ENCODER_EPS)


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
