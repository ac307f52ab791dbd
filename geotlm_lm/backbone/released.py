"""Released encoders by name and file: loaded strictly, frozen, giving the seam's tokens."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from geotlm_lm.backbone.encoder_modules import (
    ConvEncoder,
    ConvEncoderConfig,
    ImageViT,
    ImageViTConfig,
)
from geotlm_lm.backbone.encoders import ENCODERS, EncoderRow, Names, Tensors, has_axes
from geotlm_lm.backbone.pixels import Size
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.weights import listed, read_tensors, without_prefix
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights, UsageError, choice_of
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE

BATCH = 4
"""Clips per forward pass: an encoder of pictures sees four times as many images."""


class ReleasedEncoder:
    """A released encoder behind the seam of `FrozenBackbone`: clips in, tokens out."""

    def __init__(self, row: EncoderRow, module: nn.Module, image: Size) -> None:
        self.row, self.image = row, image
        self.module = module.eval().requires_grad_(False)

    @property
    def width(self) -> int:
        """Width of the global token, and of the feature DGR adds to it."""
        return self._shapes[0][-1]

    @property
    def patch_shape(self) -> tuple[int, ...]:
        """Shape of one clip's patch tokens, (2, gh, gw, d)."""
        return self._shapes[1]

    @cached_property
    def _shapes(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Shapes of one clip's tokens, read off a twin that has sizes and no numbers."""
        with torch.device("meta"):
            twin = type(self.module)(self.module.config)
        blank = np.zeros((FRAME_COUNT, IMAGE_SIDE, IMAGE_SIDE, 3), np.uint8)
        pixels = self.row.pixels(Clip(blank, background=blank[0]), self.image)
        tokens = self.row.tokens(twin, pixels[None].to("meta"))
        return tuple(tokens.global_token.shape[1:]), tuple(tokens.patches.shape[1:])

    def digest(self) -> str:
        """Return twelve hex digits of the weights."""
        digest = hashlib.sha256(self.row.name.encode())
        for name, value in self.module.state_dict().items():
            digest.update(name.encode())
            digest.update(value.cpu().contiguous().numpy().tobytes())
        return digest.hexdigest()[:12]

    def state_dict(self) -> dict[str, Tensor]:
        """Return the weights by name."""
        return self.module.state_dict()

    def describe(self) -> dict[str, Any]:
        """Return what was recognised, as plain JSON values."""
        heads = getattr(self.module.config, "heads", None)
        return {
            "encoder": self.row.name,
            "title": self.row.title,
            "parameters": sum(parameter.numel() for parameter in self.module.parameters()),
            **({} if heads is None else {"heads": heads}),
            "image_px": list(self.image),
            "global_token": [self.width],
            "patch_tokens": list(self.patch_shape),
            "digest": self.digest(),
        }

    def to(self, device: str) -> ReleasedEncoder:
        """Move the weights to `device` and return the encoder; tokens come back to the CPU."""
        self.module.to(device)
        return self

    @torch.no_grad()
    def encode(self, clips: list[Clip]) -> Tokens:
        """Return the tokens of clips of four frames with a background each, in float32."""
        weight = next(self.module.parameters())
        parts = []
        for start in range(0, len(clips), BATCH):
            batch = clips[start : start + BATCH]
            pixels = torch.stack([self.row.pixels(clip, self.image) for clip in batch])
            parts.append(self.row.tokens(self.module, pixels.to(weight.device, weight.dtype)))
        return Tokens(
            global_token=torch.cat([part.global_token for part in parts]).float().cpu(),
            patches=torch.cat([part.patches for part in parts]).float().cpu(),
            views=tuple(self.row.view(clip) for clip in clips),
        )


def load_encoder(
    path: str | Path,
    name: str | None = None,
    *,
    heads: int | None = None,
    image: Size | None = None,
) -> ReleasedEncoder:
    """Load a released encoder from the file its authors release.

    Of T3 it is the sensor's encoder, whose trunk lies beside it or one folder up. Without a name
    the file is recognised by its tensors; without heads and image they are those of the authors.

    Raises:
        UsageError: If there is no encoder of that name, or the heads must be given.
        IncompatibleWeights: If the file is not that encoder's, whole and unharmed.
    """
    path = Path(path)
    row = None if name is None else encoder_row(name)
    tensors = read_tensors(path)
    row = row or detect_encoder(path, tensors)
    module, size, parts = fitted(row, row.complete(path, tensors), path, heads, image)
    for own, value in (pair for pairs in parts.values() for pair in pairs.items()):
        if not bool(torch.isfinite(value).all()):
            raise IncompatibleWeights(
                f"{path}: {own} holds values that are not finite; get the file of {row.title} "
                f"again from {row.source}."
            )
    # Copies in any case: a tensor may still lie in the file.
    state = {
        ours: torch.cat([value.to(torch.float32) for value in pairs.values()]).contiguous()
        for ours, pairs in parts.items()
    }
    module.load_state_dict(state, assign=True)
    return ReleasedEncoder(row, module, size)


def encoder_row(name: str) -> EncoderRow:
    """Return the encoder called `name`, or raise a UsageError that names the nearest."""
    if name in ENCODERS:
        return ENCODERS[name]
    raise UsageError(f"there is no encoder '{name}'; {choice_of(name, ENCODERS)}")


def detect_encoder(path: Path, tensors: Tensors) -> EncoderRow:
    """Return the one encoder that names and shapes of a file fit, or refuse the file."""
    rows = [
        row
        for row in ENCODERS.values()
        if any(has_axes(_own_tensors(row, tensors), mark) for mark in row.marks)
    ]
    if len(rows) != 1:
        raise IncompatibleWeights(
            f"{path}: is the file of none of {', '.join(ENCODERS)}, its first names are "
            f"{listed(tensors)}; say which encoder it should be by --encoder to see what is "
            f"missing."
        )
    return rows[0]


def _own_tensors(row: EncoderRow, tensors: Tensors) -> Tensors:
    """Return the encoder's tensors by the authors' names, without prefix and bystanders."""
    for prefix in row.prefixes:
        if any(name.startswith(prefix) for name in tensors):
            tensors = without_prefix(tensors, prefix)
    starts = tuple(name for name in row.kept if name.endswith("."))
    return {
        name: value
        for name, value in tensors.items()
        if (not row.kept or name in row.kept or name.startswith(starts))
        and not any(part in name for part in row.dropped)
    }


def fitted(
    row: EncoderRow,
    tensors: Tensors,
    path: Path,
    heads: int | None = None,
    image: Size | None = None,
) -> tuple[nn.Module, Size, dict[str, Tensors]]:
    """Return the empty module, the size of its images, and by our name what each weight is made of.

    Every name of the file must be accounted for, and every shape right; values are not looked at.
    """
    tensors = _own_tensors(row, tensors)
    own = _without_constants(row, tensors, path)
    absent = [name for name in row.anchors if name not in own]
    if absent:
        raise _mismatch(row, path, absent, [n for n in (own or tensors) if n not in row.anchors])
    for name, axes in row.anchors.items():
        if own[name].ndim != axes:
            shape = tuple(own[name].shape)
            raise _refused(row, path, f"{name} has shape {shape}, expected {axes} axes")
    try:
        with torch.device("meta"):
            build = _vit if row.blocks else _conv
            module, size, names = build(row, own, path, heads, image)
    except ValueError as error:  # torch refuses sizes that its layers cannot have
        raise _refused(row, path, f"no encoder has the sizes found ({error})") from error
    expected = [name for parts in names.values() for name in parts]
    missing = [name for name in expected if name not in own]
    unexpected = sorted(set(own) - set(expected))
    if missing or unexpected:
        raise _mismatch(row, path, missing, unexpected)
    parts: dict[str, Tensors] = {}
    for ours, wanted in module.state_dict().items():
        share = (wanted.shape[0] // len(names[ours]), *wanted.shape[1:])
        parts[ours] = {}
        for name in names[ours]:
            shape = tuple(own[name].shape)
            # Many files keep leading axes of one on tokens and positions.
            if shape != (1,) * (len(shape) - len(share)) + share:
                raise _refused(row, path, f"{name} has shape {shape}, expected {share}")
            parts[ours][name] = own[name].reshape(share)
    return module, size, parts


def _without_constants(row: EncoderRow, tensors: Tensors, path: Path) -> Tensors:
    """Return the tensors without constants, once these are known to be the released ones."""
    stem = tensors.get(f"{row.weights.get('patch')}.weight")
    for name in tensors.keys() & row.constants.keys() if stem is not None else ():
        table, released = tensors[name], row.constants[name](len(stem))
        if table.shape != released.shape or not torch.allclose(table.float(), released, rtol=1e-5):
            raise IncompatibleWeights(
                f"{path}: {name} is not the table {row.title} was released with; get the file "
                f"from {row.source}."
            )
    return {name: value for name, value in tensors.items() if name not in row.constants}


def _vit(
    row: EncoderRow, tensors: Tensors, path: Path, heads: int | None, image: Size | None
) -> tuple[ImageViT, Size, Names]:
    """Size a transformer by its tensors, and map every weight by the row's table."""
    width, *_, rows, columns = (stem := tensors[f"{row.weights['patch']}.weight"]).shape
    first_mlp = f"{row.blocks[0][0]}0.{row.block_layers['fc1'][0]}.weight"
    resizes = row.parts.get("resizes_positions", False)
    grid = _grid(row, tensors, path, None if resizes else image, (rows, columns))
    sensors = tensors[row.weights["sensor_tokens"]].shape if "sensor_tokens" in row.weights else ()
    registers = tensors.get(row.weights.get("registers", ""))
    projection = f"{row.weights.get('projection')}.weight"
    blocks = [
        (f"{prefix}{number}.", eps)
        for prefix, eps in row.blocks
        for number in range(_block_count(tensors, prefix))
    ]
    config = ImageViTConfig(
        width=width,
        heads=_heads(row, path, width, heads),
        mlp_width=len(tensors[first_mlp]),
        block_eps=tuple(eps for _, eps in blocks),
        patch=tuple(stem.shape[2:]),
        grid=grid,
        has_layer_scale="gain1" in row.block_layers,
        has_global="global_token" in row.weights,
        sensor_rows=sensors[0] if sensors else 0,
        sensor_tokens=sensors[1] if sensors else 0,
        registers=0 if registers is None else registers.shape[-2],
        has_sinusoids=row.weights["positions"] not in tensors,
        projection=len(tensors[projection]) if projection in tensors else 0,
        **row.parts,
    )
    module = ImageViT(config)
    names: Names = {}
    for ours in module.state_dict():
        part, *kind = ours.split(".")
        theirs = (row.weights.get(part, ""),)
        if part == "blocks":
            index, layer, *kind = kind
            theirs = tuple(blocks[int(index)][0] + name for name in row.block_layers[layer])
        names[ours] = tuple(".".join([name, *kind]) for name in theirs)
    size = (grid[1] * rows, grid[2] * columns)
    return module, (resizes and image) or size, names


def _grid(
    row: EncoderRow, tensors: Tensors, path: Path, image: Size | None, patch: Size
) -> tuple[int, int, int]:
    """Return (bins, rows, columns) of the positions, which must fill such a grid."""
    image = image or row.image
    positions = tensors.get(row.weights["positions"])
    # Positions of an unknown image are of a square one.
    count = None if positions is None else positions.shape[-2] - ("global_token" in row.weights)
    side = math.isqrt((count or 0) // row.time_bins)
    rows, columns = (side, side) if image is None else map(int.__floordiv__, image, patch)
    if count not in (None, row.time_bins * rows * columns):
        size = "a square image" if image is None else f"{image[0]}x{image[1]} pixels"
        raise IncompatibleWeights(
            f"{path}: {count} positions, expected {row.time_bins} times a grid of {size} for "
            f"{row.title}; get the file for such images from {row.source}."
        )
    return row.time_bins, rows, columns


def _heads(row: EncoderRow, path: Path, width: int, heads: int | None) -> int:
    """Return the attention heads of a file of `width`, which no file tells."""
    heads = heads or row.released_heads.get(width)
    if heads is None:
        known = " or ".join(str(known) for known in row.released_heads)
        raise UsageError(
            f"{path}: {row.title} of width {width}, expected {known}; a file does not tell its "
            f"attention heads, give them by --heads."
        )
    if width % heads:
        raise UsageError(
            f"{path}: width {width} does not divide among {heads} attention heads; give the "
            f"number its authors trained with by --heads."
        )
    return heads


def _conv(
    row: EncoderRow, tensors: Tensors, path: Path, heads: int | None, image: Size | None
) -> tuple[ConvEncoder, Size, Names]:
    """Size a convolutional encoder by the shapes of its convolutions; parts keep their names."""
    levels = _block_count(tensors, "encoder.down.")
    widths = [len(tensors["encoder.conv_in.weight"])]
    for level in range(levels):
        conv = tensors.get(f"encoder.down.{level}.block.0.conv1.weight")
        widths.append(widths[-1] if conv is None else len(conv))
    config = ConvEncoderConfig(
        base_width=widths[0],
        widths=tuple(widths[1:]),
        blocks=_block_count(tensors, "encoder.down.0.block."),
        attention_levels=tuple(
            level
            for level in range(levels)
            if any(name.startswith(f"encoder.down.{level}.attn.") for name in tensors)
        ),
        latent_width=len(tensors["encoder.conv_out.weight"]),
        code_width=len(tensors["quant_conv.weight"]),
    )
    module = ConvEncoder(config)
    return module, image or row.image, {name: (name,) for name in module.state_dict()}


def _block_count(tensors: Mapping[str, Tensor], prefix: str) -> int:
    """Return one more than the highest block number after `prefix`: a gap shows as missing."""
    pattern = re.compile(re.escape(prefix) + r"(\d+)\.")
    numbers = [int(match[1]) for name in tensors if (match := pattern.match(name))]
    return max(numbers, default=-1) + 1


def _mismatch(
    row: EncoderRow, path: Path, missing: Iterable[str], unexpected: Iterable[str]
) -> IncompatibleWeights:
    return _refused(row, path, f"missing {listed(missing)}, unexpected {listed(unexpected)}")


def _refused(row: EncoderRow, path: Path, reason: str) -> IncompatibleWeights:
    return IncompatibleWeights(
        f"{path}: is not {row.title}: {reason}; get the file from {row.source}."
    )
