"""What the language model is taught to feel: the true word at each slot, and its loss."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy

from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.language.generation import Speaker
from geotlm_lm.language.slots import SLOTS
from geotlm_lm.training.component_truth import component_truth

UNASKED = -1
"""Stands for a slot of which nothing is asked: ambiguous, or not to be seen."""


def felt_words(labels: Sequence[MotionLabel]) -> Tensor:
    """Return the place of the true word at each slot, `UNASKED` where nothing is asked, (n, 4)."""
    places = []
    for label in labels:
        truth, row = component_truth(label), []
        for component in COMPONENTS:
            words, wanted = SLOTS[component], truth.counts[component]
            if wanted:
                row.append(words.index(truth.twist.way(component)))
            else:
                row.append(UNASKED if wanted is None else words.index("none"))
        places.append([*row, SLOTS["contact"].index("yes" if truth.is_touched else "no")])
    return torch.tensor(places)


def felt_loss(speaker: Speaker, token: Tensor, words: Tensor) -> Tensor:
    """Return the mean cross entropy of what is felt, summed over the slots, in nats.

    Args:
        speaker: Model and vocabulary.
        token: Standardised readings, (b, fused width).
        words: As `felt_words` gives them, (b, 4).
    """
    model, prompts = speaker.model, speaker.prompts
    prefix = model.projector.from_standardised(token)
    slots = model.slot_logits(prefix, prompts.slot_prompt, prompts.slot_words)
    losses = [
        cross_entropy(logits, words[:, place], ignore_index=UNASKED, reduction="sum")
        for place, logits in enumerate(slots.values())
    ]
    return torch.stack(losses).sum() / len(words)
