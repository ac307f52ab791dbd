"""What is known of a released encoder, and the strict loading of its file."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import torch
from torch import Tensor, nn

from geotlm_lm.backbone.pixels import Size
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.backbone.weights import listed, without_prefix
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights, UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, TUBE_FRAMES

Tensors = dict[str, Tensor]

Names = dict[str, tuple[str, ...]]
"""Our name of a weight -> the authors' names of its parts, joined along the first axis."""

Axes = Mapping[str, int | None]
"""Names of tensors and their numbers of axes; None for a tensor that must be absent."""


@dataclass(frozen=True)
class LoadOptions:
    """How a file is read.

    Args:
        path: The file, for messages.
        heads: Attention heads; None for those of the released width.
        image: Rows and columns of the images the encoder reads; None for what the file or the
            authors' configuration says.
    """

    path: Path
    heads: int | None = None
    image: Size | None = None


def _only(path: Path, tensors: Tensors) -> Tensors:
    return tensors


def _whole_image(clip: Clip) -> View | None:
    return View()


@dataclass(frozen=True, kw_only=True, eq=False)
class Adapter(ABC):
    """One released encoder.

    Args:
        name: What the command line calls it.
        title: What messages call it.
        source: Where the authors release the file.
        marks: The file is recognised by any one of these sets of tensors.
        anchors: Tensors whose sizes `build` reads.
        pixels: The authors' preparation of one clip of four frames at a size.
        tokens: Their forward pass over a batch of such pixels, cut to what DGR reads.
        view: The square of the image that the patch grid covers; None where it is no square.
        prefixes: What is taken off the names in turn; where a file has one, all else is dropped.
        kept: The names, or with a dot at the end their beginnings, that belong to the encoder;
            empty for all.
        dropped: Parts of names that do not belong to it.
        complete: Adds the tensors of files that belong to the one at a path.
        released_heads: Attention heads by width: a file does not tell them.
    """

    name: str
    title: str
    source: str
    marks: tuple[Axes, ...]
    anchors: Mapping[str, int]
    pixels: Callable[[Clip, Size], Tensor]
    tokens: Callable[[nn.Module, Tensor], Tokens]
    view: Callable[[Clip], View | None] = _whole_image
    prefixes: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    complete: Callable[[Path, Tensors], Tensors] = _only
    released_heads: Mapping[int, int] = field(default_factory=dict)

    @abstractmethod
    def build(self, found: Tensors, options: LoadOptions) -> tuple[nn.Module, Size]:
        """Return the empty module of the sizes found, and the size of the images it reads."""

    @abstractmethod
    def names(self, module: nn.Module, found: Tensors) -> Names:
        """Return which tensors fill the module."""

    def claims(self, tensors: Tensors) -> bool:
        """Tell whether a file looks like this encoder's."""
        found = self.select(tensors)
        return any(has_axes(found, mark) for mark in self.marks)

    def select(self, tensors: Tensors) -> Tensors:
        """Return the encoder's tensors by the authors' names, without prefix and bystanders."""
        for prefix in self.prefixes:
            if any(name.startswith(prefix) for name in tensors):
                tensors = without_prefix(tensors, prefix)
        return {
            name: value
            for name, value in tensors.items()
            if self._is_kept(name) and not any(part in name for part in self.dropped)
        }

    def _is_kept(self, name: str) -> bool:
        starts = tuple(one for one in self.kept if one.endswith("."))
        return not self.kept or name in self.kept or name.startswith(starts)

    def checked(self, found: Tensors, options: LoadOptions) -> Tensors:
        """Return `found` without constants, once they are known to be the released ones."""
        return found

    def heads(self, width: int, options: LoadOptions) -> int:
        """Return the attention heads of a file of `width`.

        Raises:
            UsageError: If they were not given and the width is not a released one, or do not divide
                the width.
        """
        heads = options.heads or self.released_heads.get(width)
        if heads is None:
            known = " or ".join(str(known) for known in self.released_heads)
            raise UsageError(
                f"{options.path}: {self.title} of width {width}, expected {known}; a file does not "
                f"tell its attention heads, give them by --heads."
            )
        if width % heads:
            raise UsageError(
                f"{options.path}: width {width} does not divide among {heads} attention heads; "
                f"give the number its authors trained with by --heads."
            )
        return heads


def has_axes(tensors: Tensors, wanted: Axes) -> bool:
    """Tell whether all of the `wanted` tensors are there, or absent, with their axes."""
    return all(
        name not in tensors if axes is None else name in tensors and tensors[name].ndim == axes
        for name, axes in wanted.items()
    )


def load_strictly(
    adapter: Adapter, tensors: Tensors, options: LoadOptions
) -> tuple[nn.Module, Size]:
    """Return the filled module and the size of its images, in float32.

    Raises:
        IncompatibleWeights: If a name is missing or unexpected, or a shape or value is wrong.
    """
    module, image, parts = fitted(adapter, tensors, options)
    for name, value in (pair for pairs in parts.values() for pair in pairs.items()):
        if not bool(torch.isfinite(value).all()):
            raise IncompatibleWeights(
                f"{options.path}: {name} holds values that are not finite; get the file of "
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
    adapter: Adapter, tensors: Tensors, options: LoadOptions
) -> tuple[nn.Module, Size, dict[str, dict[str, Tensor]]]:
    """Return the empty module, the size of its images, and by our name what each weight is made of.

    Every name of the file must be accounted for, and every shape right; values are not looked at.

    Raises:
        IncompatibleWeights: If a name is missing or unexpected, a shape is wrong, or no module can
            have the sizes found.
    """
    found = adapter.checked(adapter.select(tensors), options)
    absent = [name for name in adapter.anchors if name not in found]
    if absent:
        others = [name for name in (found or tensors) if name not in adapter.anchors]
        raise _mismatch(adapter, options, absent, others)
    for name, axes in adapter.anchors.items():
        if found[name].ndim != axes:
            raise _wrong_shape(adapter, options, name, found[name].shape, f"{axes} axes")
    try:
        with torch.device("meta"):
            module, image = adapter.build(found, options)
    except ValueError as error:  # torch refuses sizes that its layers cannot have
        raise IncompatibleWeights(
            f"{options.path}: is not {adapter.title}: no encoder has the sizes found ({error}); "
            f"get the file from {adapter.source}."
        ) from error
    names = adapter.names(module, found)
    expected = [name for parts in names.values() for name in parts]
    missing = [name for name in expected if name not in found]
    unexpected = sorted(set(found) - set(expected))
    if missing or unexpected:
        raise _mismatch(adapter, options, missing, unexpected)
    fitting = {}
    for ours, wanted in module.state_dict().items():
        share = torch.Size([wanted.shape[0] // len(names[ours]), *wanted.shape[1:]])
        fitting[ours] = {name: _without_batch_axes(found[name], share) for name in names[ours]}
        for name, value in fitting[ours].items():
            if value.shape != share:
                shape = found[name].shape
                raise _wrong_shape(adapter, options, name, shape, str(tuple(share)))
    return module, image, fitting


def _without_batch_axes(value: Tensor, shape: torch.Size) -> Tensor:
    """Drop leading axes of one, as many files keep on tokens and positions."""
    while value.ndim > len(shape) and value.shape[0] == 1:
        value = value[0]
    return value


def block_count(found: Mapping[str, Tensor], prefix: str) -> int:
    """Return one more than the highest block number after `prefix`: a gap shows as missing."""
    pattern = re.compile(re.escape(prefix) + r"(\d+)\.")
    numbers = [int(match[1]) for name in found if (match := pattern.match(name))]
    return max(numbers, default=-1) + 1


def bin_means(frames: Tensor) -> Tensor:
    """Average the two frames of each time-bin, (b, 4, ...) to (b, 2, ...)."""
    return frames.unflatten(1, (FRAME_COUNT // TUBE_FRAMES, TUBE_FRAMES)).mean(dim=2)


def _mismatch(
    adapter: Adapter, options: LoadOptions, missing: Sequence[str], unexpected: Sequence[str]
) -> IncompatibleWeights:
    return IncompatibleWeights(
        f"{options.path}: is not {adapter.title}: missing {listed(missing)}, unexpected "
        f"{listed(unexpected)}; get the file from {adapter.source}."
    )


def _wrong_shape(
    adapter: Adapter, options: LoadOptions, name: str, shape: torch.Size, wanted: str
) -> IncompatibleWeights:
    return IncompatibleWeights(
        f"{options.path}: is not {adapter.title}: {name} has shape {tuple(shape)}, expected "
        f"{wanted}; get the file from {adapter.source}."
    )
