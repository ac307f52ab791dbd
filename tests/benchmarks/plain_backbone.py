"""A backbone without weights: each patch's mean change against the idle gel, bin by bin."""

import numpy as np
import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.core.geometry import GRID_SIDE, PATCH_SIDE


class PlainBackbone:
    """Encode as said above; `gain` is its only weight."""

    def __init__(self, gain=1.0):
        self.gain = gain

    def encode(self, clips):
        patches = torch.from_numpy(np.stack([self._patches(clip) for clip in clips]))
        return Tokens(patches.mean(dim=(2, 3)).flatten(1), patches, (View(),) * len(clips))

    def _patches(self, clip):
        change = (clip.frames.astype(np.float32) - clip.background) / 16 * self.gain
        cells = (GRID_SIDE, PATCH_SIDE, GRID_SIDE, PATCH_SIDE, 3)
        patches = change.reshape(4, *cells).mean(axis=(2, 4))
        return patches.reshape(2, 2, GRID_SIDE, GRID_SIDE, 3).mean(axis=1)
