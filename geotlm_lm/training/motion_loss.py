"""How far a told displacement field is from the true one, and which clips have a true one.

One loss for the backbone's pretraining and for the grounded DGR.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor

from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.twist import Component
from geotlm_lm.training.component_truth import component_truth
from geotlm_lm.training.ranks import ALONE, Ranks

MOTION_FLOOR_PX = 1.0
"""Displacement below which errors stop counting relative to it: the flow's own noise."""

MOTION_SHARPNESS = 2.0
"""Errors above a quarter of the displacement count linearly, smaller ones by their square."""

LEAST_MASS = 0.25
"""Contact, in patches, below which a clip has no displacement to learn."""


def counts_motion(label: MotionLabel) -> bool:
    """Tell whether a clip's displacement is a target of training.

    Not where it cannot be seen, nor where the object only presses: a press's imprint spreads while
    its object stays. Asked to see through that as well, the read-outs found a fifth of a turn where
    they now find half (100 steps each, validation objects); and the spread is the press's own
    signature in the regional pooling.
    """
    truth = component_truth(label)
    if not truth.is_touched:
        return label.is_readable
    asked = (Component.TURN, Component.SLIDE)
    moves = any(truth.counts[one] for one in asked)
    is_pressed = truth.counts[Component.PRESS] is not False
    is_seen = all(truth.counts[one] is False or truth.is_readable[one] for one in asked)
    return is_seen and (moves or not is_pressed)


def motion_loss(told_px: Tensor, true_px: Tensor, weight: Tensor, ranks: Ranks = ALONE) -> Tensor:
    """Return the mean loss of the clips that have something to learn.

    Errors count relative to the clip's RMS displacement, told plus true, so that a still clip whose
    flow feigns motion counts no more than a large turn.

    Args:
        told_px: Displacement told, shape (b, ..., 2), px.
        true_px: True displacement, same shape.
        weight: Contact of each patch, shape (b, ...); 0 throughout for a clip that does not count.
        ranks: Among which the batch is shared.
    """
    places = tuple(range(1, weight.ndim))
    mass = weight.sum(dim=places)
    safe_mass = mass.clamp(min=1e-3)
    scale = MOTION_FLOOR_PX + _rms(true_px, weight) + _rms(told_px.detach(), weight)
    error = MOTION_SHARPNESS * (told_px - true_px) / scale.view(-1, *(1,) * len(places), 1)
    losses = F.smooth_l1_loss(error, torch.zeros_like(error), reduction="none", beta=0.5)
    per_clip = (losses.sum(dim=-1) * weight).sum(dim=places) / safe_mass
    is_touched = mass > LEAST_MASS
    return (per_clip * is_touched).sum() / ranks.asked_per_rank(is_touched)


def _rms(field_px: Tensor, weight: Tensor) -> Tensor:
    """Return each clip's RMS displacement over its contact, shape (b,)."""
    places = tuple(range(1, weight.ndim))
    mass = weight.sum(dim=places).clamp(min=1e-3)
    return ((field_px.square().sum(dim=-1) * weight).sum(dim=places) / mass).sqrt()
