"""What every released encoder answers for, and the strict loading they share."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import torch
from torch import Tensor, nn

from geotlm_lm.backbone.pixels import Size
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.backbone.weights import listed
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights, UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, TUBE_FRAMES

Names = dict[str, tuple[str, ...]]
"""Our name of a weight -> the authors' names of its parts, joined along the first axis."""

CLIP_BLOCK: Names = {
    "norm1": ("layer_norm1",),
    "qkv": ("self_attn.q_proj", "self_attn.k_proj", "self_attn.v_proj"),
    "proj": ("self_attn.out_proj",),
    "norm2": ("layer_norm2",),
    "fc1": ("mlp.fc1",),
    "fc2": ("mlp.fc2",),
}
"""Layers of a block as transformers' CLIP names them."""

TIMM_BLOCK: Names = {
    "norm1": ("norm1",),
    "qkv": ("attn.qkv",),
    "proj": ("attn.proj",),
    "norm2": ("norm2",),
    "fc1": ("mlp.fc1",),
    "fc2": ("mlp.fc2",),
}
"""Layers of a block as timm and DINOv2 name them."""


@dataclass(frozen=True)
class Asked:
    """What a file is read as.

    Args:
        path: The file, for messages.
        heads: Attention heads; None for those of the released width.
        image: Rows and columns of the images the encoder reads; None for what the file or the
            authors' configuration says.
    """

    path: Path
    heads: int | None = None
    image: Size | None = None


class Adapter(ABC):
    """One released encoder.

    `select` leaves what the encoder consists of, `build` makes the empty module of the sizes found,
    `names` says which tensor goes where, `pixels` is the authors' preparation of one clip, `tokens`
    their forward pass cut to what DGR reads.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    source: ClassVar[str]
    """Where the authors release the file."""
    mark: ClassVar[tuple[str, int]]
    """A tensor by which the file is recognised, and its number of axes."""
    anchors: ClassVar[Mapping[str, int]]
    """Tensors whose sizes `build` reads, and their numbers of axes."""
    released_heads: ClassVar[Mapping[int, int]] = {}
    """Attention heads by width: a file does not tell them."""

    def claims(self, tensors: dict[str, Tensor]) -> bool:
        """Tell whether a file looks like this encoder's."""
        name, axes = self.mark
        found = self.select(tensors).get(name)
        return found is not None and found.ndim == axes

    def complete(self, path: Path, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Return `tensors` with those of files that belong to the one at `path`."""
        return tensors

    @abstractmethod
    def select(self, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
        """Return the encoder's tensors by the authors' names, without prefix and bystanders."""

    def checked(self, found: dict[str, Tensor], asked: Asked) -> dict[str, Tensor]:
        """Return `found` without constants, once they are known to be the released ones."""
        return found

    @abstractmethod
    def build(self, found: dict[str, Tensor], asked: Asked) -> tuple[nn.Module, Size]:
        """Return the empty module of the sizes found, and the size of the images it reads."""

    @abstractmethod
    def names(self, module: nn.Module) -> Names:
        """Return which tensors fill the module."""

    @abstractmethod
    def pixels(self, clip: Clip, image: Size) -> Tensor:
        """Return what the authors' module would receive for one clip of four frames."""

    @abstractmethod
    def tokens(self, module: nn.Module, pixels: Tensor) -> Tokens:
        """Return the tokens of a batch of what `pixels` gives."""

    def view(self, clip: Clip) -> View | None:
        """Return the square of the image that the grid covers; None where it is no square."""
        return View()

    def heads(self, width: int, asked: Asked) -> int:
        """Return the attention heads of a file of `width`.

        Raises:
            UsageError: If they were not given and the width is not a released one, or do not divide
                the width.
        """
        heads = asked.heads or self.released_heads.get(width)
        if heads is None:
            known = " or ".join(str(known) for known in self.released_heads)
            raise UsageError(
                f"{asked.path}: {self.title} of width {width}, expected {known}; a file does not "
                f"tell its attention heads, give them by --heads."
            )
        if width % heads:
            raise UsageError(
                f"{asked.path}: width {width} does not divide among {heads} attention heads; give "
                f"the number its authors trained with by --heads."
            )
        return heads


def load_strictly(
    adapter: Adapter, tensors: dict[str, Tensor], asked: Asked
) -> tuple[nn.Module, Size]:
    """Return the filled module and the size of its images, in float32.

    Raises:
        IncompatibleWeights: If a name is missing or unexpected, or a shape or value is wrong.
    """
    module, image, parts = fitted(adapter, tensors, asked)
    for name, value in (pair for pairs in parts.values() for pair in pairs.items()):
        if not bool(torch.isfinite(value).all()):
            raise IncompatibleWeights(
                f"{asked.path}: {name} holds values that are not finite; get the file of "
                f"{adapter.title} again from {adapter.source}."
            )
    # Copies in any case: a tensor may still lie in the file.
    state = {
        ours: torch.cat([value.to(torch.float32) for value in pairs.values()]).contiguous()
        for ours, pairs in parts.items()
    }
    module.load_state_dict(state, assign=True)
    return module.eval().requires_grad_(False), image


def fitted(
    adapter: Adapter, tensors: dict[str, Tensor], asked: Asked
) -> tuple[nn.Module, Size, dict[str, dict[str, Tensor]]]:
    """Return the empty module, the size of its images, and by our name what each weight is made of.

    Every name of the file must be accounted for, and every shape right; values are not looked at.

    Raises:
        IncompatibleWeights: If a name is missing or unexpected, a shape is wrong, or no module can
            have the sizes found.
    """
    found = adapter.checked(adapter.select(tensors), asked)
    absent = [name for name in adapter.anchors if name not in found]
    if absent:
        others = [name for name in (found or tensors) if name not in adapter.anchors]
        raise _mismatch(adapter, asked, absent, others)
    for name, axes in adapter.anchors.items():
        if found[name].ndim != axes:
            raise _wrong_shape(adapter, asked, name, found[name].shape, f"{axes} axes")
    try:
        with torch.device("meta"):
            module, image = adapter.build(found, asked)
    except ValueError as error:  # torch refuses sizes that its layers cannot have
        raise IncompatibleWeights(
            f"{asked.path}: is not {adapter.title}: no encoder has the sizes found ({error}); get "
            f"the file from {adapter.source}."
        ) from error
    names = adapter.names(module)
    expected = [name for parts in names.values() for name in parts]
    missing = [name for name in expected if name not in found]
    unexpected = sorted(set(found) - set(expected))
    if missing or unexpected:
        raise _mismatch(adapter, asked, missing, unexpected)
    fitting = {}
    for ours, wanted in module.state_dict().items():
        share = torch.Size([wanted.shape[0] // len(names[ours]), *wanted.shape[1:]])
        fitting[ours] = {name: _without_batch_axes(found[name], share) for name in names[ours]}
        for name, value in fitting[ours].items():
            if value.shape != share:
                shape = found[name].shape
                raise _wrong_shape(adapter, asked, name, shape, str(tuple(share)))
    return module, image, fitting


def _without_batch_axes(value: Tensor, shape: torch.Size) -> Tensor:
    """Drop leading axes of one, as many files keep on tokens and positions."""
    while value.ndim > len(shape) and value.shape[0] == 1:
        value = value[0]
    return value


def block_names(ours: str, theirs: str, style: Names) -> Names:
    """Return the names of one block's weights and biases.

    Args:
        ours: Prefix of the block in our module.
        theirs: Prefix of the block in the authors' file.
        style: Their names of its layers.
    """
    return {
        f"{ours}{layer}.{kind}": tuple(f"{theirs}{part}.{kind}" for part in parts)
        for layer, parts in style.items()
        for kind in ("weight", "bias")
    }


def block_count(found: Mapping[str, Tensor], prefix: str) -> int:
    """Return one more than the highest block number after `prefix`: a gap shows as missing."""
    pattern = re.compile(re.escape(prefix) + r"(\d+)\.")
    numbers = [int(match[1]) for name in found if (match := pattern.match(name))]
    return max(numbers, default=-1) + 1


def square_grid(
    adapter: Adapter, asked: Asked, patches: int, patch: Size, bins: int = 1
) -> tuple[int, int, int]:
    """Return (bins, rows, columns) of learned positions, square unless the image is said.

    Raises:
        IncompatibleWeights: If the positions do not fill such a grid.
    """
    if asked.image:
        rows, columns = (asked.image[axis] // patch[axis] for axis in range(2))
    else:
        rows = columns = math.isqrt(patches // bins)
    if bins * rows * columns != patches:
        size = "a square image" if not asked.image else f"{asked.image[0]}x{asked.image[1]} pixels"
        raise IncompatibleWeights(
            f"{asked.path}: {patches} positions, expected {bins} times a grid of {size} for "
            f"{adapter.title}; get the file for such images from {adapter.source}."
        )
    return bins, rows, columns


def bin_means(frames: Tensor) -> Tensor:
    """Average the two frames of each time-bin, (b, 4, ...) to (b, 2, ...)."""
    return frames.unflatten(1, (FRAME_COUNT // TUBE_FRAMES, TUBE_FRAMES)).mean(dim=2)


def _mismatch(
    adapter: Adapter, asked: Asked, missing: Sequence[str], unexpected: Sequence[str]
) -> IncompatibleWeights:
    return IncompatibleWeights(
        f"{asked.path}: is not {adapter.title}: missing {listed(missing)}, unexpected "
        f"{listed(unexpected)}; get the file from {adapter.source}."
    )


def _wrong_shape(
    adapter: Adapter, asked: Asked, name: str, shape: torch.Size, wanted: str
) -> IncompatibleWeights:
    return IncompatibleWeights(
        f"{asked.path}: is not {adapter.title}: {name} has shape {tuple(shape)}, expected "
        f"{wanted}; get the file from {adapter.source}."
    )
