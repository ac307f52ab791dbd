"""What a backbone returns: one global token and a grid of patch tokens per time-bin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from torch import Tensor

from geotlm_lm.backbone.motions import Motions
from geotlm_lm.backbone.view import View
from geotlm_lm.core.clip import Clip


@dataclass(frozen=True, eq=False)
class Tokens:
    """Tokens of a batch of clips."""

    global_token: Tensor  # summary c of each clip, shape (b, d)
    patches: Tensor  # patch tokens F, shape (b, 2, gh, gw, d), early time-bin first (Eq. 1)
    # The square of the image each clip's grid covers, None where it covers no square; empty where
    # nobody asked.
    views: tuple[View | None, ...] = ()
    # What the stem made of each clip, (b, 2, gh, gw, dim); None where the backbone has no stem,
    # or nobody asked.
    inputs: Tensor | None = None
    # The rigid motions the stem found in each clip; empty likewise.
    motions: tuple[Motions, ...] = ()

    def __len__(self) -> int:
        return len(self.global_token)


class Backbone(Protocol):
    """The seam between clips and geometry, behind which the embedded and released encoders are."""

    @property
    def width(self) -> int:
        """Width d of the global token."""

    def encode(self, clips: list[Clip]) -> Tokens:
        """Return the tokens of clips of four frames with a background each, in float32."""

    def state_dict(self) -> dict[str, Tensor]:
        """Return the frozen weights by name."""
