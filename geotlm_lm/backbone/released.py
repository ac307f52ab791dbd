"""Released encoders by name and file: loaded strictly, frozen, giving the seam's tokens."""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from geotlm_lm.backbone.adapters.adapter import Adapter, LoadOptions, load_strictly
from geotlm_lm.backbone.adapters.anytouch import ANYTOUCH1, ANYTOUCH2
from geotlm_lm.backbone.adapters.internvit import INTERNVIT
from geotlm_lm.backbone.adapters.sparsh import SPARSH
from geotlm_lm.backbone.adapters.t3 import T3
from geotlm_lm.backbone.adapters.unit import UNIT
from geotlm_lm.backbone.pixels import Size
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.weights import listed, read_tensors
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights, UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE

ENCODERS: dict[str, Adapter] = {
    adapter.name: adapter for adapter in (ANYTOUCH2, ANYTOUCH1, SPARSH, T3, INTERNVIT, UNIT)
}
"""Every released encoder by the name the command line gives it."""

BATCH = 4
"""Clips per forward pass: an encoder of pictures sees four times as many images."""


class ReleasedEncoder:
    """A released encoder behind the seam of `FrozenBackbone`: clips in, tokens out.

    Args:
        adapter: What is known of the encoder.
        module: Its weights, frozen.
        image: Rows and columns of the images it reads.
    """

    def __init__(self, adapter: Adapter, module: nn.Module, image: Size) -> None:
        self.adapter, self.image = adapter, image
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
        """Shapes of one clip's tokens, found on a twin that has sizes and no numbers."""
        with torch.device("meta"):
            twin = type(self.module)(self.module.config)
        blank = np.zeros((FRAME_COUNT, IMAGE_SIDE, IMAGE_SIDE, 3), np.uint8)
        pixels = self.adapter.pixels(Clip(blank, background=blank[0]), self.image)
        tokens = self.adapter.tokens(twin, pixels[None].to("meta"))
        return tuple(tokens.global_token.shape[1:]), tuple(tokens.patches.shape[1:])

    @property
    def parameter_count(self) -> int:
        """How many numbers the encoder was loaded with."""
        return sum(parameter.numel() for parameter in self.module.parameters())

    def digest(self) -> str:
        """Return twelve hex digits of the weights."""
        found = hashlib.sha256(self.adapter.name.encode())
        for name, value in self.module.state_dict().items():
            found.update(name.encode())
            found.update(value.cpu().contiguous().numpy().tobytes())
        return found.hexdigest()[:12]

    def state_dict(self) -> dict[str, Tensor]:
        """Return the weights by name."""
        return self.module.state_dict()

    def describe(self) -> dict[str, Any]:
        """Return what was recognised, as plain JSON values."""
        heads = getattr(self.module.config, "heads", None)
        return {
            "encoder": self.adapter.name,
            "title": self.adapter.title,
            "parameters": self.parameter_count,
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
        parts = [self._encode(batch) for batch in _batches(clips)]
        return Tokens(
            global_token=torch.cat([part.global_token for part in parts]).float().cpu(),
            patches=torch.cat([part.patches for part in parts]).float().cpu(),
            views=tuple(self.adapter.view(clip) for clip in clips),
        )

    def _encode(self, clips: list[Clip]) -> Tokens:
        weight = next(self.module.parameters())
        pixels = torch.stack([self.adapter.pixels(clip, self.image) for clip in clips])
        return self.adapter.tokens(self.module, pixels.to(weight.device, weight.dtype))


def _batches(clips: list[Clip]) -> Iterator[list[Clip]]:
    for start in range(0, len(clips), BATCH):
        yield clips[start : start + BATCH]


def load_encoder(
    path: str | Path,
    name: str | None = None,
    *,
    heads: int | None = None,
    image: Size | None = None,
) -> ReleasedEncoder:
    """Load a released encoder from the file its authors release.

    Args:
        path: The file; of T3 the sensor's encoder, whose trunk lies beside it or one folder up.
        name: One of `ENCODERS`; None recognises the file by its names.
        heads: Attention heads; None for those of the released width.
        image: Rows and columns of the images it shall read; None for the authors'.

    Raises:
        UsageError: If there is no encoder of that name, or the heads must be told.
        IncompatibleWeights: If the file is not that encoder's, whole and unharmed.
    """
    path = Path(path)
    adapter = None if name is None else adapter_named(name)
    tensors = read_tensors(path)
    adapter = adapter or detect_encoder(path, tensors)
    options = LoadOptions(path, heads, image)
    module, size = load_strictly(adapter, adapter.complete(path, tensors), options)
    return ReleasedEncoder(adapter, module, size)


def adapter_named(name: str) -> Adapter:
    """Return the encoder called `name`.

    Raises:
        UsageError: If there is none.
    """
    if name in ENCODERS:
        return ENCODERS[name]
    near = difflib.get_close_matches(name.lower(), ENCODERS, 1)
    hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(ENCODERS)}."
    raise UsageError(f"there is no encoder '{name}'; {hint}")


def detect_encoder(path: Path, tensors: dict[str, Tensor]) -> Adapter:
    """Return the one encoder a file's names and shapes belong to.

    Raises:
        IncompatibleWeights: If there is none.
    """
    found = [adapter for adapter in ENCODERS.values() if adapter.claims(tensors)]
    if len(found) != 1:
        raise IncompatibleWeights(
            f"{path}: is the file of none of {', '.join(ENCODERS)}, its first names are "
            f"{listed(tensors)}; say which encoder it should be by --encoder to see what is "
            f"missing."
        )
    return found[0]
