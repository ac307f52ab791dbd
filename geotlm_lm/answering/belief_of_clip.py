"""What is believed of a clip, and what the language model feels of it, once for all questions."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.geometry import pixel_aspect
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.slots import SLOTS
from geotlm_lm.motion.belief import Belief
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import BELIEF_NUMBERS, belief_of_one
from geotlm_lm.recordings.touch import UNTOUCHED_PROBABILITY


@torch.inference_mode()
def belief_of(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what is believed of a clip, given its perception.

    What is faint or cut off is believed with a wider spread, and less surely.
    """
    perception = encoded.perception
    inputs, motions = perception.inputs, perception.motions
    if inputs is None or not motions:  # a released encoder has no stem of its own
        stem = measure_clip(encoded.clip)
        inputs, motions = torch.from_numpy(stem.inputs[None]), (stem.motions,)
    found = torch.from_numpy(motions[0].numbers())[None]
    aspect = pixel_aspect(*encoded.clip.frames.shape[1:3])
    told = bundle.motion(
        measured(inputs, found, perception.geometry, perception.fused_token, aspect)
    )
    belief = belief_of_one(told, doubt=encoded.doubt)
    touched = _contact(belief.contact, encoded)
    ways = {way: share * touched for way, share in belief.ways.items()}
    return replace(belief, ways=ways, contact=touched)


@torch.inference_mode()
def felt_words(bundle: Bundle, encoded: Encoded) -> tuple[dict[Motion, float], float]:
    """Return what the language model feels in its slots: the ways that count, and contact.

    Returns:
        Probability that each way's component counts and goes that way, and that something touches.
    """
    slots = bundle.speaker.feel(reading(encoded)[None])
    shares = {
        slot: dict(
            zip(
                SLOTS[slot],
                bundle.calibration.felt(logits[0].double().numpy(), doubt=encoded.doubt).tolist(),
                strict=True,
            )
        )
        for slot, logits in slots.items()
    }
    touched = _contact(shares.pop("contact")["yes"], encoded)
    ways = {
        Motion(word): share * touched
        for words in shares.values()
        for word, share in words.items()
        if word != "none"
    }
    return ways, touched


def reading(encoded: Encoded) -> Tensor:
    """Return what the language model reads of a clip: z, then what is believed, (width,)."""
    token = encoded.perception.fused_token[0].float()
    numbers = encoded.belief.numbers or (0.0,) * BELIEF_NUMBERS
    return torch.cat([token, torch.tensor(numbers, dtype=token.dtype)])


def _contact(told: float, encoded: Encoded) -> float:
    """Return how probable it is that something touches, by what is told and by the pictures."""
    if encoded.is_untouched:
        return 1 - UNTOUCHED_PROBABILITY
    return max(told, UNTOUCHED_PROBABILITY) if encoded.is_changed else told
