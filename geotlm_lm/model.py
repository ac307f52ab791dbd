"""GeoTLM's perception, read like the paper's figure: clip -> tokens -> geometry -> fused token.

The language side starts where this file ends: it receives the fused token and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.backbone.motions import Motions
from geotlm_lm.backbone.tokens import Backbone, Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.process import in_one_thread
from geotlm_lm.dgr.encoder import DGR, Geometry
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser


@dataclass(frozen=True, eq=False)
class Perception:
    """What the model perceives in a batch of clips.

    Args:
        global_token: Standardised global token c, shape (b, d).
        geometry: Everything DGR computed.
        fused_token: z = c + g, shape (b, d) (Eq. 9).
        views: The square of the image each clip's grid covers; None where it covers no square.
        inputs: What the stem made of each clip, (b, 2, gh, gw, dim); None where the backbone has no
            stem.
        motions: The rigid motions the stem found in each clip; empty likewise.
    """

    global_token: Tensor
    geometry: Geometry
    fused_token: Tensor
    views: tuple[View | None, ...] = ()
    inputs: Tensor | None = None
    motions: tuple[Motions, ...] = ()


@dataclass(eq=False)
class GeoTLM:
    """A frozen backbone, the geometry read from its tokens, and two linear probes.

    Args:
        backbone: Clips to tokens, frozen.
        global_standardiser: Statistics of the training split's global tokens.
        patch_standardiser: Statistics of the training split's patch tokens.
        dgr: Patch tokens to geometry.
        probe: The paper's read-out of the fused token.
        global_probe: The same read-out without DGR: the controlled ablation.
    """

    backbone: Backbone
    global_standardiser: Standardiser
    patch_standardiser: Standardiser
    dgr: DGR
    probe: LinearProbe
    global_probe: LinearProbe

    def perceive(self, clips: list[Clip]) -> Perception:
        """Perceive clips of four frames with a background each."""
        return self.fuse(self.backbone.encode(clips))  # Eq. 1

    @in_one_thread()
    @torch.inference_mode()
    def fuse(self, tokens: Tokens) -> Perception:
        """Add the geometric feature to the global token (Eqs. 2-9)."""
        global_token = self.global_standardiser.apply(tokens.global_token)
        patches = self.patch_standardiser.apply(tokens.patches)
        geometry = self.dgr(patches)  # Eqs. 2-8
        fused_token = global_token + geometry.feature  # Eq. 9
        seen = tokens.views, tokens.inputs, tokens.motions
        return Perception(global_token, geometry, fused_token, *seen)


def contact_centre(geometry: Geometry, view: View, size: tuple[int, int]) -> tuple[float, float]:
    """Return the middle of the contact in one clip, pixels of its own frames, (x, y).

    The middle of the squared mask: of 133 simulated contacts it lies 9 pixels of a 224-pixel image
    from the true middle (median), 24 in one of ten.

    Args:
        geometry: Of one clip.
        view: The square of the image that its grid covers.
        size: Rows and columns of the clip's own frames.
    """
    weight = geometry.mask[0].double().square().numpy()
    rows, columns = weight.shape
    down, right = (np.indices(weight.shape) * weight).sum(axis=(1, 2)) / max(weight.sum(), 1e-12)
    x, y = view.in_picture(np.array([(right + 0.5) / columns, (down + 0.5) / rows]))
    return float(np.clip(x, 0, 1) * size[1]), float(np.clip(y, 0, 1) * size[0])
