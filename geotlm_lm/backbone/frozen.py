"""The embedded backbone: clips in, tokens out, no gradient, for ever in evaluation mode."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.vit import ViT
from geotlm_lm.core.clip import Clip

ENCODE_BATCH = 32
"""Clips per forward pass: larger batches gained nothing on two cores."""


class FrozenBackbone:
    """A trained ViT behind the stem; the seam between clips and geometry.

    Args:
        vit: Trained weights; its parameters lose their gradients here.
    """

    def __init__(self, vit: ViT) -> None:
        self.vit = vit.eval().requires_grad_(False)

    @property
    def width(self) -> int:
        """Width d of every token."""
        return self.vit.config.width

    def state_dict(self) -> dict[str, Tensor]:
        """Return the weights by name."""
        return self.vit.state_dict()

    def encode(self, clips: list[Clip]) -> Tokens:
        """Return the tokens of clips of four frames with a background each, in float32."""
        inputs, views, motions = zip(*(measure_clip(clip) for clip in clips), strict=True)
        stacked = torch.from_numpy(np.stack(inputs))
        tokens = self.encode_inputs(stacked)
        return replace(tokens, views=views, inputs=stacked, motions=motions)

    @torch.inference_mode()
    def encode_inputs(self, inputs: Tensor) -> Tokens:
        """Return the tokens of patch inputs that the stem made, shape (b, 2, gh, gw, dim)."""
        device = self.vit.global_token.device
        parts = [self.vit(part.to(device).float()) for part in inputs.split(ENCODE_BATCH)]
        return Tokens(
            global_token=torch.cat([part.global_token for part in parts]).cpu(),
            patches=torch.cat([part.patches for part in parts]).cpu(),
        )
