"""A pre-norm vision transformer over patches, each token holding both time-bins of its patch.

How a patch moved is the difference of its two time-bins, which a token finds within itself; tokens
for each time-bin, as AnyTouch 2 has them, have to find it by attention among twice as many.
Measured after 1,000 steps, 128 wide in 392 tokens against 160 wide in 196: kind of motion of clips
of other objects 0.904 and 0.923, pretraining loss 1.00 and 0.94, in 0.61 of the time; one clip on
one thread, four blocks deep, 12.8 and 8.1 ms. Two blocks, trained a quarter longer, tell as much
(docs/tried.md).

Token order: 1 global, 5 sensor, then the patches, rows before columns. Sensor tokens carry no
position. No norm follows the last block: a token's length carries how far its patch moved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE, SENSOR_TOKEN_COUNT, TIME_BIN_COUNT
from geotlm_lm.core.process import in_one_thread

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


_ONEDNN = (
    getattr(torch.ops.mkldnn, "_linear_pointwise", None)
    if torch.backends.mkldnn.is_available()
    else None
)
"""oneDNN's product in float32, the one `torch.compile` emits, without a compiler's start-up. An
operator of torch's own that other releases may lack; `nn.Linear` alone is offered to users and goes
through MKL, which leaves half of an AMD processor's vector units idle: 202 tokens of width 160 to
640 take 0.41 ms there and 0.21 ms here, the whole transformer of one clip 4.8 and 3.4 ms."""


def linear(layer: nn.Module, values: Tensor, *, gelu: bool = False) -> Tensor:
    """Return what a linear layer makes of (..., d_in): (..., d_out), equal but for rounding.

    With `gelu` it is the exact GELU of that. All layers but plain ones in float32 on the CPU,
    without gradients, are simply called. Of these no hooks are run, and autocasting does not reach
    them.
    """
    if (
        _ONEDNN is None
        or type(layer) is not nn.Linear
        or torch.is_grad_enabled()
        or values.device.type != "cpu"
        or values.dtype != torch.float32
        or layer.weight.dtype != torch.float32
    ):
        return F.gelu(layer(values)) if gelu else layer(values)
    return _ONEDNN(values, layer.weight, layer.bias, "gelu" if gelu else "none", [], "none")


class Block(nn.Module):
    """One pre-norm block: attention, then an exact-GELU MLP, each added to its input.

    With a layer scale, what is added is first multiplied by a learned gain per channel, as some
    released encoders do.
    """

    def __init__(
        self,
        width: int,
        heads: int,
        hidden: int,
        *,
        norm_eps: float = NORM_EPS,
        has_layer_scale: bool = False,
    ) -> None:
        super().__init__()
        self.heads = heads
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
        hidden = linear(self.fc2, linear(self.fc1, self.norm2(tokens), gelu=True))
        return tokens + (hidden if self.gain2 is None else self.gain2 * hidden)


class ViT(nn.Module):
    """Turn patch inputs into tokens."""

    def __init__(self, config: ViTConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        self.embed = nn.Linear(TIME_BIN_COUNT * config.input_dim, width)
        self.global_token = nn.Parameter(torch.empty(width))
        self.sensor_tokens = nn.Parameter(torch.empty(SENSOR_TOKEN_COUNT, width))
        self.positions = nn.Parameter(torch.empty(1 + config.grid_side**2, width))
        self.blocks = nn.ModuleList(
            Block(width, config.heads, MLP_RATIO * width) for _ in range(config.depth)
        )
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
        """Encode patch inputs, shape (b, 2, gh, gw, input_dim)."""
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


ENCODE_BATCH = 32
"""Clips per forward pass: larger batches gained nothing on two cores."""


class FrozenBackbone:
    """A trained ViT behind the stem, for ever in evaluation mode; clips in, tokens out.

    Its parameters lose their gradients here.
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

    @in_one_thread()
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
