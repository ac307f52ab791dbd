"""What the model believes of a few frames of a stream: the learned part of a track."""

from __future__ import annotations

from collections.abc import Callable

import torch

from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import pixel_aspect
from geotlm_lm.motion.belief import Belief
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import belief_of_one

Believe = Callable[[Clip], Belief]
"""Four frames with their idle gel, to what is believed of the motion from the first to the last."""


def believer(bundle: Bundle) -> Believe:
    """Return what asks a bundle's perception and motion network; no word is generated."""

    @torch.inference_mode()
    def believe(clip: Clip) -> Belief:
        seen = bundle.model.perceive([clip])
        inputs, motions = seen.inputs, seen.motions
        if inputs is None or not motions:  # a released encoder has no stem of its own
            stem = measure_clip(clip)
            inputs, motions = torch.from_numpy(stem.inputs[None]), (stem.motions,)
        found = torch.from_numpy(motions[0].numbers())[None]
        aspect = pixel_aspect(*clip.frames.shape[1:3])
        return belief_of_one(
            bundle.motion(measured(inputs, found, seen.geometry, seen.fused_token, aspect))
        )

    return believe
