"""UniT (ZhengtongXu/UniT): the convolutional encoder of a VQGAN, frame by frame."""

from __future__ import annotations

import cv2
import numpy as np
from torch import Tensor

from geotlm_lm.backbone.adapters.adapter import (
    Adapter,
    LoadOptions,
    Names,
    Tensors,
    bin_means,
    block_count,
)
from geotlm_lm.backbone.conv_encoder import ConvEncoder, ConvEncoderConfig
from geotlm_lm.backbone.pixels import Size, four_frames, to_unit
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.clip import Clip

IMAGE: Size = (128, 160)
FIRST_CONV = "encoder.conv_in.weight"
FIRST_LEVEL = "encoder.down.0.block.0.conv1.weight"
LAST_CONV = "encoder.conv_out.weight"
QUANT_CONV = "quant_conv.weight"


class ConvAdapter(Adapter):
    """The encoder of a VQGAN; the module's parts are named as the file's."""

    def build(self, found: Tensors, options: LoadOptions) -> tuple[ConvEncoder, Size]:
        """Size the module by the shapes of its convolutions."""
        levels = block_count(found, "encoder.down.")
        widths = [len(found[FIRST_CONV])]
        for level in range(levels):
            conv = found.get(f"encoder.down.{level}.block.0.conv1.weight")
            widths.append(widths[-1] if conv is None else len(conv))
        config = ConvEncoderConfig(
            base_width=widths[0],
            widths=tuple(widths[1:]),
            blocks=block_count(found, "encoder.down.0.block."),
            attention_levels=tuple(
                level
                for level in range(levels)
                if any(name.startswith(f"encoder.down.{level}.attn.") for name in found)
            ),
            latent_width=len(found[LAST_CONV]),
            code_width=len(found[QUANT_CONV]),
        )
        return ConvEncoder(config), options.image or IMAGE

    def names(self, module: ConvEncoder, found: Tensors) -> Names:
        """Map every name to itself."""
        return {name: (name,) for name in module.state_dict()}


def blue_first(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, rows, columns) in [0, 1], blue first, as the authors' recorder stores them.

    Resizing is OpenCV's, without antialiasing, of float images.
    """
    frames = four_frames(clip)[..., ::-1].astype(np.float32)
    frames = np.stack([cv2.resize(frame, image[::-1]) for frame in frames])
    return to_unit(frames)


def latent_tokens(module: ConvEncoder, pixels: Tensor) -> Tokens:
    """Return tokens of clips (b, 4, 3, rows, columns); the global one is the flat latent.

    A mean over the grid would leave three numbers; the authors read the whole grid too.
    """
    latent = module(pixels.flatten(0, 1)).unflatten(0, (len(pixels), -1))  # b t d gh gw
    return Tokens(latent.flatten(2).mean(dim=1), bin_means(latent.movedim(2, -1)))


UNIT = ConvAdapter(
    name="unit",
    title="UniT",
    source="https://github.com/ZhengtongXu/UniT (a folder of checkpoints, linked from the README)",
    marks=({QUANT_CONV: 4},),
    anchors={FIRST_CONV: 4, FIRST_LEVEL: 4, LAST_CONV: 4, QUANT_CONV: 4},
    pixels=blue_first,
    tokens=latent_tokens,
    kept=("encoder.", "quant_conv."),
)
"""The latent before quantisation is a grid of tokens three numbers wide."""
