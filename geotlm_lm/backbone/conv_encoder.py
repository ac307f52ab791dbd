"""The convolutional encoder of a VQGAN: levels of residual blocks, halved in between.

Parts are named as released files name them. Knows nothing of files or of how pixels were prepared.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch.nn.functional as F
from torch import Tensor, nn

GROUPS, NORM_EPS = 32, 1e-6


@dataclass(frozen=True)
class ConvEncoderConfig:
    """Sizes of an encoder.

    Args:
        base_width: Channels after the first convolution.
        widths: Channels of each level.
        blocks: Residual blocks in a level.
        attention_levels: Levels in which an attention follows every block.
        latent_width: Channels the encoder ends with.
        code_width: Channels after the convolution that follows it.
    """

    base_width: int
    widths: tuple[int, ...]
    blocks: int
    attention_levels: tuple[int, ...]
    latent_width: int
    code_width: int


class ConvEncoder(nn.Module):
    """Turn images into their latent before quantisation.

    Args:
        config: Sizes.
    """

    def __init__(self, config: ConvEncoderConfig) -> None:
        super().__init__()
        self.config = config
        self.encoder = _Encoder(config)
        self.quant_conv = nn.Conv2d(config.latent_width, config.code_width, 1)

    def forward(self, images: Tensor) -> Tensor:
        """Return the latent (b, code_width, rows / 8, columns / 8) of four levels.

        Args:
            images: Shape (b, 3, rows, columns), in [0, 1].
        """
        return self.quant_conv(self.encoder(images))


class _Encoder(nn.Module):
    def __init__(self, config: ConvEncoderConfig) -> None:
        super().__init__()
        self.conv_in = nn.Conv2d(3, config.base_width, 3, padding=1)
        befores = (config.base_width, *config.widths[:-1])
        self.down = nn.ModuleList(
            _Level(
                before,
                width,
                config.blocks,
                has_attention=level in config.attention_levels,
                halves=level < len(config.widths) - 1,
            )
            for level, (before, width) in enumerate(zip(befores, config.widths, strict=True))
        )
        width = config.widths[-1]
        self.mid = _Middle(width)
        self.norm_out = _norm(width)
        self.conv_out = nn.Conv2d(width, config.latent_width, 3, padding=1)

    def forward(self, images: Tensor) -> Tensor:
        x = self.conv_in(images)
        for level in self.down:
            x = level(x)
        return self.conv_out(F.silu(self.norm_out(self.mid(x))))


class _Level(nn.Module):
    def __init__(
        self, before: int, width: int, blocks: int, *, has_attention: bool, halves: bool
    ) -> None:
        super().__init__()
        self.block = nn.ModuleList(
            ResidualBlock(width if index else before, width) for index in range(blocks)
        )
        attentions = blocks if has_attention else 0
        self.attn = nn.ModuleList(GridAttention(width) for _ in range(attentions))
        self.downsample = _Halving(width) if halves else None

    def forward(self, x: Tensor) -> Tensor:
        for index, block in enumerate(self.block):
            x = block(x)
            x = self.attn[index](x) if len(self.attn) else x
        return x if self.downsample is None else self.downsample(x)


class _Middle(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.block_1 = ResidualBlock(width, width)
        self.attn_1 = GridAttention(width)
        self.block_2 = ResidualBlock(width, width)

    def forward(self, x: Tensor) -> Tensor:
        return self.block_2(self.attn_1(self.block_1(x)))


class _Halving(nn.Module):
    """A convolution of stride two, padded at the right and at the bottom only."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.conv = nn.Conv2d(width, width, 3, stride=2)

    def forward(self, x: Tensor) -> Tensor:
        return self.conv(F.pad(x, (0, 1, 0, 1)))


class ResidualBlock(nn.Module):
    """Twice norm, x * sigmoid(x) and a 3 x 3 convolution, added to the input."""

    def __init__(self, before: int, width: int) -> None:
        super().__init__()
        self.norm1 = _norm(before)
        self.conv1 = nn.Conv2d(before, width, 3, padding=1)
        self.norm2 = _norm(width)
        self.conv2 = nn.Conv2d(width, width, 3, padding=1)
        self.nin_shortcut = nn.Conv2d(before, width, 1) if before != width else None

    def forward(self, x: Tensor) -> Tensor:
        """Return the image at the block's width."""
        inner = self.conv1(F.silu(self.norm1(x)))
        inner = self.conv2(F.silu(self.norm2(inner)))
        return inner + (x if self.nin_shortcut is None else self.nin_shortcut(x))


class GridAttention(nn.Module):
    """One head of attention between all places of the grid, added to the input."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.norm = _norm(width)
        self.q = nn.Conv2d(width, width, 1)
        self.k = nn.Conv2d(width, width, 1)
        self.v = nn.Conv2d(width, width, 1)
        self.proj_out = nn.Conv2d(width, width, 1)

    def forward(self, x: Tensor) -> Tensor:
        """Return the image with what each place has read from the others."""
        normed = self.norm(x)
        query, key, value = (
            layer(normed).flatten(2).transpose(1, 2) for layer in (self.q, self.k, self.v)
        )  # (b, places, d)
        mixed = F.scaled_dot_product_attention(query, key, value)
        return x + self.proj_out(mixed.transpose(1, 2).unflatten(2, x.shape[2:]))


def _norm(width: int) -> nn.GroupNorm:
    return nn.GroupNorm(GROUPS, width, eps=NORM_EPS)
