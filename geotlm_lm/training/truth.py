"""The truth of a labelled clip: each component's, and the displacement that training asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F
from torch import Tensor

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.simulation.truth import components_of, twist_of
from geotlm_lm.training.ranks import ALONE, Ranks

UNASKED = -1
"""Stands for a place, or a slot, of which nothing is asked."""

MOTION_FLOOR_PX = 1.0
"""Displacement below which errors stop counting relative to it: the flow's own noise."""

MOTION_SHARPNESS = 2.0
"""Errors above a quarter of the displacement count linearly, smaller ones by their square."""

LEAST_MASS = 0.25
"""Contact, in patches, below which a clip has no displacement to learn."""


@dataclass(frozen=True)
class ClipTruth:
    """What is true of a clip, component by component."""

    twist: Twist  # the motion about the middle of the contact
    # Whether each component moves; None where it does so too little to be graded, or unseen.
    moves: Mapping[Component, bool | None]
    # Whether the picture tells how far each component goes, and which way.
    is_readable: Mapping[Component, bool]
    is_touched: bool  # whether anything touches the gel


def component_truth(label: MotionLabel) -> ClipTruth:
    """Return what a label tells of each component.

    On an untouched gel none moves.
    """
    is_touched = label.motion is not Motion.NONE and max(label.contact_fraction, default=1.0) > 0
    if not is_touched:
        nothing = dict.fromkeys(COMPONENTS, False)
        return ClipTruth(Twist(), nothing, nothing, is_touched=False)
    label = replace(label, travel_px=label.travel_px or (0.0, 0.0))
    parts = components_of(label)
    return ClipTruth(
        twist_of(label),
        {
            component: None if part.moves and not part.is_visible else part.moves
            for component, part in parts.items()
        },
        {component: part.is_visible for component, part in parts.items()},
        is_touched=True,
    )


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
    moves = any(truth.moves[component] for component in asked)
    is_pressed = truth.moves[Component.PRESS] is not False
    is_seen = all(
        truth.moves[component] is False or truth.is_readable[component] for component in asked
    )
    return is_seen and (moves or not is_pressed)


def motion_loss(stated_px: Tensor, true_px: Tensor, weight: Tensor, ranks: Ranks = ALONE) -> Tensor:
    """Return the mean loss of the clips that have something to learn.

    Errors count relative to the clip's RMS displacement, stated plus true, so that a still clip
    whose flow feigns motion counts no more than a large turn. One loss for the backbone's
    pretraining and for the grounded DGR.

    Displacements are (b, ..., 2); `weight`, (b, ...), is the contact of each patch, 0 throughout
    for a clip that does not count.
    """
    places = tuple(range(1, weight.ndim))
    mass = weight.sum(dim=places)
    safe_mass = mass.clamp(min=1e-3)
    scale = MOTION_FLOOR_PX + _rms(true_px, weight) + _rms(stated_px.detach(), weight)
    error = MOTION_SHARPNESS * (stated_px - true_px) / scale.view(-1, *(1,) * len(places), 1)
    losses = F.smooth_l1_loss(error, torch.zeros_like(error), reduction="none", beta=0.5)
    per_clip = (losses.sum(dim=-1) * weight).sum(dim=places) / safe_mass
    is_touched = mass > LEAST_MASS
    return (per_clip * is_touched).sum() / ranks.asked_per_rank(is_touched)


def _rms(field_px: Tensor, weight: Tensor) -> Tensor:
    """Return each clip's RMS displacement over its contact, shape (b,)."""
    places = tuple(range(1, weight.ndim))
    mass = weight.sum(dim=places).clamp(min=1e-3)
    return ((field_px.square().sum(dim=-1) * weight).sum(dim=places) / mass).sqrt()
