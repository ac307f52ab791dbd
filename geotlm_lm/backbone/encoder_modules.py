"""Modules of released encoders: one vision transformer for all of them, and one convolutional.

The transformer has the blocks of the embedded backbone; stem, extra tokens, positions and outer
norms differ by configuration. Nothing here knows of files or of how pixels were prepared.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.vit import Block


@dataclass(frozen=True)
class ImageViTConfig:
    """Sizes and parts of a transformer."""

    width: int
    heads: int
    mlp_width: int  # width of the hidden layer of a block's MLP
    block_eps: tuple[float, ...]  # norm epsilon of each block, first block first
    # Kernel and stride of the stem: (rows, columns), or with its depth before them.
    patch: tuple[int, ...]
    grid: tuple[int, int, int]  # patches along (time, row, column) that the positions were made for
    has_patch_bias: bool = True
    has_layer_scale: bool = False
    has_global: bool = True  # whether a global token leads; it has a position of its own
    sensor_rows: int = 0  # sensors that have tokens of their own; 0 for none
    sensor_tokens: int = 0  # tokens of each sensor, after the global token, without position
    registers: int = 0  # tokens that belong to no patch, before the patches, without position
    has_sinusoids: bool = False  # whether positions are computed, and not learned
    resizes_positions: bool = False
    pre_norm_eps: float | None = None
    norm_eps: float | None = None
    projection: int = 0  # width of a projection after the last norm; 0 for none

    @property
    def lead(self) -> int:
        """Tokens before the first patch."""
        return self.has_global + (self.sensor_tokens if self.sensor_rows else 0) + self.registers


class ImageViT(nn.Module):
    """Turn pixels into tokens."""

    def __init__(self, config: ImageViTConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        stem = {2: nn.Conv2d, 3: nn.Conv3d}[len(config.patch)]
        self.patch = stem(3, width, config.patch, config.patch, bias=config.has_patch_bias)
        self.global_token = _weights(width) if config.has_global else None
        self.sensor_tokens = _weights(config.sensor_rows, config.sensor_tokens, width)
        self.registers = _weights(config.registers, width)
        rows = 0 if config.has_sinusoids else config.has_global + math.prod(config.grid)
        self.positions = _weights(rows, width)
        self.pre_norm = _norm(width, config.pre_norm_eps)
        self.blocks = nn.ModuleList(
            Block(
                width,
                config.heads,
                config.mlp_width,
                norm_eps=eps,
                has_layer_scale=config.has_layer_scale,
            )
            for eps in config.block_eps
        )
        self.norm = _norm(width, config.norm_eps)
        self.projection = (
            nn.Linear(width, config.projection, bias=False) if config.projection else nn.Identity()
        )

    def forward(self, pixels: Tensor, sensors: Tensor | None = None) -> Tensor:
        """Return all tokens after the last block, before any norm, shape (b, n, d).

        Pixels are (b, 3, rows, columns), or (b, 3, depth, rows, columns); `sensors` are the rows of
        each clip's sensor tokens, (b,).
        """
        tokens = self.embed(pixels, sensors)
        for block in self.blocks:
            tokens = block(tokens)
        return tokens

    def embed(self, pixels: Tensor, sensors: Tensor | None = None) -> Tensor:
        """Return the tokens that enter the first block."""
        grid = self.patch(pixels)
        patches = grid.flatten(2).transpose(1, 2)  # (b, n, d), time slowest, rows before columns
        b = len(patches)
        global_position, positions = self.positions_for(tuple(grid.shape[2:]))
        lead = []
        if self.global_token is not None:
            lead.append((self.global_token + global_position).expand(b, 1, -1))
        if self.sensor_tokens is not None:
            if sensors is None:
                raise ValueError("the encoder has sensor tokens: say which sensor took each clip")
            lead.append(self.sensor_tokens[sensors])
        if self.registers is not None:
            lead.append(self.registers.expand(b, -1, -1))
        tokens = torch.cat([*lead, patches + positions], dim=1)
        return tokens if self.pre_norm is None else self.pre_norm(tokens)

    def positions_for(self, grid: tuple[int, ...]) -> tuple[Tensor, Tensor]:
        """Return the position of the global token, (1, d), and of every patch, (n, d).

        `grid` counts the patches along (row, column) or (time, row, column).
        """
        grid = (1,) * (3 - len(grid)) + grid
        if self.config.has_sinusoids:
            table = sinusoids(grid, self.config.width).to(self.patch.weight)
            return table.new_zeros(1, self.config.width), table
        at = int(self.config.has_global)
        own, table = self.positions[:at], self.positions[at:]
        if grid == self.config.grid:
            return own, table
        if not self.config.resizes_positions:
            raise ValueError(f"positions are of a grid {self.config.grid}, the pixels give {grid}")
        # Bicubic, half-pixel centres; in float32, as the encoder's authors do: float64 would differ
        # from them by 1e-7.
        image = table.float().unflatten(0, self.config.grid[1:]).permute(2, 0, 1)[None]
        image = F.interpolate(image, size=grid[1:], mode="bicubic", align_corners=False)
        return own, image[0].flatten(1).T.to(table.dtype)

    def normed(self, tokens: Tensor) -> Tensor:
        """Return tokens after the outer norm; as they are where there is none."""
        return tokens if self.norm is None else self.norm(tokens)

    def patch_grid(self, tokens: Tensor, grid: tuple[int, int, int] | None = None) -> Tensor:
        """Return the patch tokens on their grid, shape (b, time, rows, columns, d)."""
        return tokens[:, self.config.lead :].unflatten(1, grid or self.config.grid)


def sinusoids(grid: tuple[int, int, int], width: int) -> Tensor:
    """Return the position of every patch, float32 (n, width), time slowest.

    A third of the width belongs to each axis, in the order time, row, column: first the sines, then
    the cosines of the index times frequencies that fall geometrically from 1 towards 1/10000
    (Sparsh, `SinusoidalEmbed`).
    """
    frequencies = sinusoid_frequencies(width)
    indices = torch.meshgrid(*(torch.arange(n) for n in grid), indexing="ij")
    angles = [index.flatten().float()[:, None] * frequencies for index in indices]
    parts = [part for angle in angles for part in (angle.sin(), angle.cos())]
    return torch.cat(parts, dim=-1)[:, :width]


def sinusoid_frequencies(width: int) -> Tensor:
    """Return the frequencies of one axis; of the last axis the few last may not be needed."""
    count = math.ceil(width / 6)
    return 10000.0 ** -torch.linspace(0, 1, count + 1)[:-1]


def _weights(*sizes: int) -> nn.Parameter | None:
    """Return an empty parameter, or None where there would be none of them."""
    return nn.Parameter(torch.empty(*sizes)) if sizes[0] else None


def _norm(width: int, eps: float | None) -> nn.LayerNorm | None:
    return None if eps is None else nn.LayerNorm(width, eps=eps)


GROUPS, GROUP_EPS = 32, 1e-6


@dataclass(frozen=True)
class ConvEncoderConfig:
    """Channels of each level, residual blocks in a level, and levels with attention after each."""

    base_width: int
    widths: tuple[int, ...]
    blocks: int
    attention_levels: tuple[int, ...]
    latent_width: int
    code_width: int


class ConvEncoder(nn.Module):
    """The encoder of a VQGAN: images to their latent before quantisation.

    Levels of residual blocks, halved in between; parts are named as released files name them.
    """

    def __init__(self, config: ConvEncoderConfig) -> None:
        super().__init__()
        self.config = config
        self.encoder = _Encoder(config)
        self.quant_conv = nn.Conv2d(config.latent_width, config.code_width, 1)

    def forward(self, images: Tensor) -> Tensor:
        """Return the latent (b, code_width, rows / 8, columns / 8) of four levels.

        Images are (b, 3, rows, columns), in [0, 1].
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
        self.mid = nn.ModuleDict(
            {
                "block_1": ResidualBlock(width, width),
                "attn_1": GridAttention(width),
                "block_2": ResidualBlock(width, width),
            }
        )
        self.norm_out = nn.GroupNorm(GROUPS, width, eps=GROUP_EPS)
        self.conv_out = nn.Conv2d(width, config.latent_width, 3, padding=1)

    def forward(self, images: Tensor) -> Tensor:
        x = self.conv_in(images)
        for part in (*self.down, *self.mid.values()):
            x = part(x)
        return self.conv_out(F.silu(self.norm_out(x)))


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
        conv = nn.Conv2d(width, width, 3, stride=2) if halves else None
        self.downsample = nn.ModuleDict({"conv": conv}) if halves else None

    def forward(self, x: Tensor) -> Tensor:
        for index, block in enumerate(self.block):
            x = block(x)
            x = self.attn[index](x) if len(self.attn) else x
        if self.downsample is None:
            return x
        # Padded at the right and at the bottom only.
        return self.downsample["conv"](F.pad(x, (0, 1, 0, 1)))


class ResidualBlock(nn.Module):
    """Twice norm, x * sigmoid(x) and a 3 x 3 convolution, added to the input."""

    def __init__(self, before: int, width: int) -> None:
        super().__init__()
        self.norm1 = nn.GroupNorm(GROUPS, before, eps=GROUP_EPS)
        self.conv1 = nn.Conv2d(before, width, 3, padding=1)
        self.norm2 = nn.GroupNorm(GROUPS, width, eps=GROUP_EPS)
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
        self.norm = nn.GroupNorm(GROUPS, width, eps=GROUP_EPS)
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
