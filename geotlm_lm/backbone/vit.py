"""A pre-norm vision transformer over patch tokens of two time-bins, in AnyTouch 2's token layout.

Token order: 1 global, 5 sensor, then the patches, time slowest, rows before columns. Sensor tokens
carry no position. No norm follows the last block: a token's length carries how far its patch moved.
Knows nothing of how patch inputs are made from frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.geometry import GRID_SIDE, SENSOR_TOKEN_COUNT, TIME_BIN_COUNT


@dataclass(frozen=True)
class ViTConfig:
    """Sizes of a transformer; `input_dim` is the length of one patch input."""

    input_dim: int
    width: int = 192
    depth: int = 4
    heads: int = 4
    grid_side: int = GRID_SIDE
    mlp_ratio: int = 4
    norm_eps: float = 1e-5

    @property
    def mlp_width(self) -> int:
        """Width of the hidden layer of a block's MLP."""
        return self.width * self.mlp_ratio


class BlockSizes(Protocol):
    """What a block asks of a configuration."""

    @property
    def width(self) -> int:
        """Width d of a token."""

    @property
    def heads(self) -> int:
        """Attention heads."""

    @property
    def mlp_width(self) -> int:
        """Width of the hidden layer of the MLP."""


class Block(nn.Module):
    """One pre-norm block: attention, then an exact-GELU MLP, each added to its input.

    Args:
        config: Sizes.
        norm_eps: Epsilon of both norms.
        has_layer_scale: Whether what is added is first multiplied by a learned gain per channel, as
            some released encoders do.
    """

    def __init__(
        self, config: BlockSizes, *, norm_eps: float = 1e-5, has_layer_scale: bool = False
    ) -> None:
        super().__init__()
        width, hidden = config.width, config.mlp_width
        self.heads = config.heads
        self.norm1 = nn.LayerNorm(width, eps=norm_eps)
        self.qkv = nn.Linear(width, 3 * width)
        self.proj = nn.Linear(width, width)
        self.norm2 = nn.LayerNorm(width, eps=norm_eps)
        self.fc1 = nn.Linear(width, hidden)
        self.fc2 = nn.Linear(hidden, width)
        self.gain1 = nn.Parameter(torch.empty(width)) if has_layer_scale else None
        self.gain2 = nn.Parameter(torch.empty(width)) if has_layer_scale else None

    def forward(self, tokens: Tensor) -> Tensor:
        """Return updated tokens, shape (b, n, d)."""
        b, n, d = tokens.shape
        qkv = self.qkv(self.norm1(tokens)).view(b, n, 3, self.heads, d // self.heads)
        query, key, value = qkv.permute(2, 0, 3, 1, 4)
        mixed = F.scaled_dot_product_attention(query, key, value)
        mixed = self.proj(mixed.transpose(1, 2).reshape(b, n, d))
        tokens = tokens + (mixed if self.gain1 is None else self.gain1 * mixed)
        hidden = self.fc2(F.gelu(self.fc1(self.norm2(tokens))))
        return tokens + (hidden if self.gain2 is None else self.gain2 * hidden)


class ViT(nn.Module):
    """Turn patch inputs into tokens.

    Args:
        config: Sizes.
    """

    def __init__(self, config: ViTConfig) -> None:
        super().__init__()
        self.config = config
        width, patch_count = config.width, TIME_BIN_COUNT * config.grid_side**2
        self.embed = nn.Linear(config.input_dim, width)
        self.global_token = nn.Parameter(torch.empty(width))
        self.sensor_tokens = nn.Parameter(torch.empty(SENSOR_TOKEN_COUNT, width))
        self.positions = nn.Parameter(torch.empty(1 + patch_count, width))
        self.blocks = nn.ModuleList(
            Block(config, norm_eps=config.norm_eps) for _ in range(config.depth)
        )

    def initialise(self, generator: torch.Generator) -> ViT:
        """Draw every weight afresh: matrices N(0, 1/fan_in), tokens and positions N(0, 0.02).

        What a block adds starts at zero: the first tokens are linear in the patch inputs, so that
        learning begins from the stem's flow.
        """
        for name, parameter in self.named_parameters():
            with torch.no_grad():
                if name.endswith(("bias", "proj.weight", "fc2.weight")):
                    parameter.zero_()
                elif "norm" in name:
                    parameter.fill_(1.0)
                elif name.endswith("weight"):
                    parameter.normal_(0, parameter.shape[1] ** -0.5, generator=generator)
                else:
                    parameter.normal_(0, 0.02, generator=generator)
        return self

    def forward(self, patch_inputs: Tensor) -> Tokens:
        """Encode a batch.

        Args:
            patch_inputs: Shape (b, 2, gh, gw, input_dim).
        """
        b = len(patch_inputs)
        side, width = self.config.grid_side, self.config.width
        patches = self.embed(patch_inputs).reshape(b, -1, width) + self.positions[1:]
        lead = torch.cat([(self.global_token + self.positions[0])[None], self.sensor_tokens])
        tokens = torch.cat([lead.expand(b, -1, -1), patches], dim=1)
        for block in self.blocks:
            tokens = block(tokens)
        grid = tokens[:, 1 + SENSOR_TOKEN_COUNT :].view(b, TIME_BIN_COUNT, side, side, width)
        return Tokens(global_token=tokens[:, 0], patches=grid)
