"""What is believed of a clip's motion, made once for all questions."""

from __future__ import annotations

import time
from dataclasses import replace
from math import inf

import torch
from torch import Tensor

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.twist import WAYS, Component
from geotlm_lm.motion.belief import Belief, fused, kept_from_zero
from geotlm_lm.motion.network import BELIEF_NUMBERS
from geotlm_lm.query.speaker import TactilePrefix
from geotlm_lm.recordings.touch import UNTOUCHED_PROBABILITY
from geotlm_lm.track.block import believed

CLEAR = 10.0
"""Path over its limit from which on nothing that grows feigns it."""


def belief_of(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what is believed of a clip, given its perception.

    What is faint or cut off is believed with a wider spread, and less surely. A contact that grows
    may look as if it turned or slid: where it is pressed and either of these is not far beyond its
    limit, the clip is perceived once more, played backwards, and what does not turn round with it
    is not believed.
    """
    belief = _first_belief(bundle, encoded)
    moving = [part for part in (Component.TURN, Component.SLIDE) if belief.moves(part) >= 0.5]
    doubtful = [part for part in moving if belief.path(part) < CLEAR * belief.limits.get(part, inf)]
    # Where contact is not known, nor is whether it is pressed.
    is_pressed = belief.moves(Component.PRESS) >= 0.5 or not encoded.is_contact_known
    if not (doubtful and is_pressed):
        return belief
    started, clip = time.perf_counter(), encoded.clip.reversed()
    backwards = replace(encoded, clip=clip, perception=bundle.model.perceive([clip]))
    belief = kept_from_zero(fused(belief, _first_belief(bundle, backwards)))
    encoded.timing_ms["backwards"] = 1e3 * (time.perf_counter() - started)
    return belief


def _first_belief(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what is believed of a clip seen once, and of contact by what the pictures tell too."""
    belief = believed(bundle.motion, encoded.clip, encoded.perception, encoded.doubt)
    if not encoded.is_contact_known:  # a press looks like a release then
        ways = belief.ways | dict.fromkeys(WAYS[Component.PRESS], 0.0)
        return replace(belief, ways=ways, is_contact_known=False)
    touched = _contact(belief.contact, encoded)
    ways = {way: share * touched for way, share in belief.ways.items()}
    return replace(belief, ways=ways, contact=touched)


def reading(encoded: Encoded) -> Tensor:
    """Return what the language model reads of a clip: z, then what is believed, (width,)."""
    token = encoded.perception.fused_token[0].float()
    numbers = encoded.belief.numbers or (0.0,) * BELIEF_NUMBERS
    return torch.cat([token, torch.tensor(numbers, dtype=token.dtype)])


def prefix_of(bundle: Bundle, encoded: Encoded) -> TactilePrefix:
    """Return how the language model sees a clip."""
    return bundle.speaker.prefix(reading(encoded).numpy())


def _contact(believed: float, encoded: Encoded) -> float:
    """Return how probable it is that something touches, by what is told and by the pictures."""
    if encoded.is_untouched:
        return 1 - UNTOUCHED_PROBABILITY
    return max(believed, UNTOUCHED_PROBABILITY) if encoded.is_changed else believed
