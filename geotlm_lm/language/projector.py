"""Fused token -> tactile prefix embeddings; knows its width and scale, not what it means."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn.functional import gelu


class Projector(nn.Module):
    """Standardise a fused token and map it to prefix embeddings with one hidden layer.

    The mean and the scale are persistent buffers: part of the weights file, so that they cannot
    come back as garbage from a model built on the meta device.

    Args:
        fused_width: Width of the fused token.
        width: Width of the decoder.
        tactile_tokens: Prefix embeddings per clip.
    """

    def __init__(self, fused_width: int, width: int, tactile_tokens: int) -> None:
        super().__init__()
        self.tactile_tokens = tactile_tokens
        self.register_buffer("mean", torch.zeros(fused_width))
        self.register_buffer("scale", torch.ones(fused_width))
        self.expand = nn.Linear(fused_width, width)
        self.project = nn.Linear(width, tactile_tokens * width)

    @torch.no_grad()
    def standardise_by(self, fused_tokens: Tensor) -> None:
        """Take mean and scale from training tokens (n, fused_width); a constant feature keeps 1."""
        deviation = fused_tokens.std(dim=0, correction=0)
        self.mean.copy_(fused_tokens.mean(dim=0))
        self.scale.copy_(torch.where(deviation > 1e-6, deviation, 1.0))

    def standardise(self, fused_token: Tensor) -> Tensor:
        """Return the token in units of its spread over the training clips."""
        return (fused_token - self.mean) / self.scale

    def forward(self, fused_token: Tensor) -> Tensor:
        """Return the prefix, (b, fused_width) -> (b, tactile_tokens, width)."""
        return self.from_standardised(self.standardise(fused_token))

    def from_standardised(self, standardised: Tensor) -> Tensor:
        """Return the prefix of tokens that are already standardised."""
        prefix = self.project(gelu(self.expand(standardised)))
        return prefix.unflatten(-1, (self.tactile_tokens, -1))
