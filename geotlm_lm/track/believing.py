"""What the model believes of four frames, given how they were perceived; writes no word."""

from __future__ import annotations

from collections.abc import Callable

import torch

from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import pixel_aspect
from geotlm_lm.model import GeoTLM, Perception
from geotlm_lm.motion.belief import Belief
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import MotionNetwork, belief_of_one

Believe = Callable[[Clip], Belief]
"""Four frames with their idle gel, to what is believed of the motion from the first to the last."""


def believer(model: GeoTLM, motion: MotionNetwork) -> Believe:
    """Return what asks a model's perception and its motion network; no word is generated."""

    def believe(clip: Clip) -> Belief:
        return believed(motion, clip, model.perceive([clip]))

    return believe


@torch.inference_mode()
def believed(
    motion: MotionNetwork, clip: Clip, perception: Perception, doubt: float = 1.0
) -> Belief:
    """Return what is believed of a clip seen once.

    Args:
        motion: The network that believes.
        clip: Four frames with their idle gel.
        perception: Of it, batch of one.
        doubt: What widens the spread and flattens the probabilities.
    """
    inputs, motions = perception.inputs, perception.motions
    if inputs is None or not motions:  # a released encoder has no stem of its own
        stem = measure_clip(clip)
        inputs, motions = torch.from_numpy(stem.inputs[None]), (stem.motions,)
    found = torch.from_numpy(motions[0].numbers())[None]
    aspect = pixel_aspect(*clip.frames.shape[1:3])
    seen = measured(inputs, found, perception.geometry, perception.fused_token, aspect)
    return belief_of_one(motion(seen), doubt=doubt)
