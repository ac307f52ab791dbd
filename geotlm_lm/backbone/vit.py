"""A pre-norm vision transformer over patches, each token holding both time-bins of its patch.

How a patch moved is the difference of its two time-bins, which a token finds within itself; tokens
for each time-bin, as AnyTouch 2 has them, have to find it by attention among twice as many.
Measured after 1,000 steps, 128 wide in 392 tokens against 160 wide in 196: kind of motion of clips
of other objects 0.904 and 0.923, pretraining loss 1.00 and 0.94, in 0.61 of the time; one clip on
one thread, four blocks deep, 12.8 and 8.1 ms. Two blocks, trained a quarter longer, tell as much
(docs/tried.md).

Token order: 1 global, 5 sensor, then the patches, rows before columns. Sensor tokens carry no
position. No norm follows the last block: a token's length carries how far its patch moved. Knows
nothing of how patch inputs are made from frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.linear import linear
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.geometry import GRID_SIDE, SENSOR_TOKEN_COUNT, TIME_BIN_COUNT

MLP_RATIO, NORM_EPS = 4, 1e-5
"""Width of a block's hidden layer over a token's, and epsilon of its norms, as in AnyTouch 2."""


@dataclass(frozen=True)
class ViTConfig:
    """Sizes of a transformer; `input_dim` is the length of one patch input."""

    input_dim: int
    width: int = 192
    depth: int = 4
    heads: int = 4
    grid_side: int = GRID_SIDE

    @property
    def mlp_width(self) -> int:
        """Width of the hidden layer of a block's MLP."""
        return self.width * MLP_RATIO


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
        self, config: BlockSizes, *, norm_eps: float = NORM_EPS, has_layer_scale: bool = False
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
        qkv = linear(self.qkv, self.norm1(tokens)).view(b, n, 3, self.heads, d // self.heads)
        query, key, value = qkv.permute(2, 0, 3, 1, 4)
        mixed = F.scaled_dot_product_attention(query, key, value)
        mixed = linear(self.proj, mixed.transpose(1, 2).reshape(b, n, d))
        tokens = tokens + (mixed if self.gain1 is None else self.gain1 * mixed)
        hidden = linear(self.fc2, F.gelu(linear(self.fc1, self.norm2(tokens))))
        return tokens + (hidden if self.gain2 is None else self.gain2 * hidden)


class ViT(nn.Module):
    """Turn patch inputs into tokens.

    Args:
        config: Sizes.
    """

    def __init__(self, config: ViTConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        self.embed = nn.Linear(TIME_BIN_COUNT * config.input_dim, width)
        self.global_token = nn.Parameter(torch.empty(width))
        self.sensor_tokens = nn.Parameter(torch.empty(SENSOR_TOKEN_COUNT, width))
        self.positions = nn.Parameter(torch.empty(1 + config.grid_side**2, width))
        self.blocks = nn.ModuleList(Block(config) for _ in range(config.depth))
        self.split = nn.Linear(width, TIME_BIN_COUNT * width)

    def initialise(self, generator: torch.Generator) -> ViT:
        """Draw every weight afresh: matrices N(0, 1/fan_in), tokens and positions N(0, 0.02).

        What a block adds starts at zero, and the split undoes the embedding as far as the width
        allows: the first tokens are linear in the inputs of their own time-bin, so that learning
        begins from the stem's flow.
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
        with torch.no_grad():
            apart = torch.linalg.pinv(self.embed.weight.double()).float()
            one_bin = self.embed_one_bin()
            parts = apart.split(self.config.input_dim)
            self.split.weight.copy_(torch.cat([one_bin @ part for part in parts]))
        return self

    def embed_one_bin(self) -> Tensor:
        """Return what embeds the early time-bin's inputs, (width, input_dim); no copy."""
        return self.embed.weight[:, : self.config.input_dim]

    def forward(self, patch_inputs: Tensor) -> Tokens:
        """Encode a batch.

        Args:
            patch_inputs: Shape (b, 2, gh, gw, input_dim).
        """
        b = len(patch_inputs)
        side, width = self.config.grid_side, self.config.width
        both = patch_inputs.permute(0, 2, 3, 1, 4).reshape(b, side * side, -1)
        patches = linear(self.embed, both) + self.positions[1:]
        lead = torch.cat([(self.global_token + self.positions[0])[None], self.sensor_tokens])
        tokens = torch.cat([lead.expand(b, -1, -1), patches], dim=1)
        for block in self.blocks:
            tokens = block(tokens)
        bins = linear(self.split, tokens[:, 1 + SENSOR_TOKEN_COUNT :])
        grid = bins.view(b, side, side, TIME_BIN_COUNT, width).permute(0, 3, 1, 2, 4)
        return Tokens(global_token=tokens[:, 0], patches=grid.contiguous())
