"""Dense targets and losses of pretraining, from the simulator's ground truth.

Patch tokens learn, through one linear map, how far the imprint moved, whether the patch is in
contact and how deep. The global token learns how much is touched, how deep, how much moves, how
far the view is magnified, what kind of motion it is (turning or sliding, pressing or letting go),
and by how many degrees or millimetres. No loss asks it which way, though attention lets it give
most of that away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.mirror import Mirror, mirrored_field, mirrored_inputs
from geotlm_lm.backbone.stem import ALIGNED_AT, FLOW_SCALE_PX, MAGNIFICATION_AT
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.labels import ROTATIONS, SLIDES, MotionClass, MotionLabel, motion_class
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.motion_loss import counts_motion, motion_loss

GLOBAL_TARGET_COUNT = 6
DEPTH_SCALE_MM = 0.3

KIND_SHARE = 1.0
"""Weight of the loss that asks for the kind of motion: most wrong answers mistake the kind."""

AMOUNT_SHARE = 0.5
"""Weight of the loss that asks how far it turned or slid."""

AMOUNT_SCALES = (4.0, 0.4)
"""Degrees of turning and mm of sliding from which on errors count relative to the amount: a fifth
of it or 2 degrees and 0.2 mm are right in an answer."""

UNSEEN = -1
"""Stands for the kind of a motion that leaves no trace."""

_KINDS = tuple(MotionClass)


class DenseHeads(nn.Module):
    """Linear read-outs used only while pretraining.

    Args:
        width: Width of a token.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.patch = nn.Linear(width, 4)
        self.summary = nn.Linear(width, GLOBAL_TARGET_COUNT)
        self.kind = nn.Linear(width, len(MotionClass))
        self.amount = nn.Linear(width, len(AMOUNT_SCALES))

    @torch.no_grad()
    def start_from_alignment(self, embed: Tensor) -> None:
        """Let displacement begin as the stem's alignment of the relief, linear in the tokens.

        Args:
            embed: What first makes a token of a patch's inputs, (width, inputs).

        Measured: a read-out that starts at random had not found a turn again after 500 steps.
        """
        back = torch.linalg.pinv(embed.double()).to(embed.dtype)
        nn.init.zeros_(self.patch.weight)
        nn.init.zeros_(self.patch.bias)
        self.patch.weight[:2] = back[ALIGNED_AT : ALIGNED_AT + 2]


@dataclass(frozen=True, eq=False)
class DenseTruth:
    """One batch of truth on the device, float32; shapes as in `Examples`.

    `counts_motion` is 1 for the clips whose displacement is a target; `kind` is the place of the
    motion's kind in `MotionClass`, `UNSEEN` where the motion leaves no trace; `amount` holds the
    degrees turned and mm slid, (b, 2), NaN where the motion is another or leaves no trace;
    `magnification` is what the stem tells of the view, (b,).
    """

    displacement: Tensor
    contact: Tensor
    depth: Tensor
    counts_motion: Tensor
    kind: Tensor
    amount: Tensor
    magnification: Tensor


def dense_loss(tokens: Tokens, heads: DenseHeads, truth: DenseTruth) -> Tensor:
    """Return the pretraining loss of one batch."""
    shift, contact_logit, depth = heads.patch(tokens.patches).split([2, 1, 1], dim=-1)
    contact_logit, depth = contact_logit.squeeze(-1), depth.squeeze(-1)
    weight = truth.contact * truth.counts_motion[:, None, None, None]
    moved = motion_loss(shift * FLOW_SCALE_PX, truth.displacement, weight)
    contact = F.binary_cross_entropy_with_logits(contact_logit, truth.contact)
    deep = F.smooth_l1_loss(depth, truth.depth / DEPTH_SCALE_MM)
    summary = F.smooth_l1_loss(heads.summary(tokens.global_token), _summary(truth))
    kind = F.cross_entropy(
        heads.kind(tokens.global_token), truth.kind, ignore_index=UNSEEN, reduction="sum"
    ) / (truth.kind != UNSEEN).sum().clamp(min=1)
    amount = amount_loss(heads.amount(tokens.global_token), truth.amount)
    return moved + contact + 0.3 * deep + summary + KIND_SHARE * kind + AMOUNT_SHARE * amount


def amount_loss(told: Tensor, true: Tensor) -> Tensor:
    """Return the mean error of the amounts there are, each on a scale that bends to a logarithm.

    Args:
        told: Read from the global tokens, (b, 2).
        true: Degrees turned and mm slid, (b, 2), NaN where there is none.
    """
    is_asked = ~true.isnan()
    scaled = torch.log1p(true.nan_to_num() / true.new_tensor(AMOUNT_SCALES))
    errors = F.smooth_l1_loss(told, scaled, reduction="none", beta=0.1)
    return (errors * is_asked).sum() / is_asked.sum().clamp(min=1)


def _summary(truth: DenseTruth) -> Tensor:
    """Return what the global token has to know: no direction is among it."""
    share = truth.contact.mean(dim=(2, 3))
    depth = truth.depth.mean(dim=(2, 3)) / (share + 0.05) / DEPTH_SCALE_MM
    weighted = truth.displacement.square().sum(dim=-1) * truth.contact
    moved_px = (weighted.mean(dim=(1, 2, 3)) / (share.mean(dim=1) + 1e-4)).sqrt()
    whole = [torch.log1p(moved_px), truth.magnification]
    return torch.cat([share.sqrt() * 2, depth, torch.stack(whole, dim=1)], dim=1)


def dense_batch(examples: Examples, rows: np.ndarray, device: str) -> tuple[Tensor, DenseTruth]:
    """Return inputs and truth of the examples `rows` on a device, in float32."""

    def moved(values: np.ndarray) -> Tensor:
        return torch.from_numpy(values[rows]).to(device).float()

    counts = np.array([counts_motion(examples.labels[row]) for row in rows], dtype=np.float32)
    inputs = moved(examples.inputs)
    truth = DenseTruth(
        displacement=moved(examples.displacement_px),
        contact=moved(examples.contact),
        depth=moved(examples.depth_mm),
        counts_motion=torch.from_numpy(counts).to(device),
        kind=torch.tensor([_kind(examples.labels[row]) for row in rows], device=device),
        amount=torch.tensor([_amounts(examples.labels[row]) for row in rows], device=device),
        magnification=inputs[:, 0, 0, 0, MAGNIFICATION_AT],
    )
    return inputs, truth


def mirrored_at_random(
    inputs: Tensor, truth: DenseTruth, rng: np.random.Generator
) -> tuple[Tensor, DenseTruth]:
    """Return a batch of which each mirror, drawn on its own, shows half: a clip has four looks.

    Of clips it had been pretrained on a backbone without this told the kind of motion at 0.973, of
    others of the same objects at 0.948.
    """
    displacement, contact, depth = truth.displacement, truth.contact, truth.depth
    for mirror in Mirror:
        chosen = torch.from_numpy(rng.random(len(inputs)) < 0.5).to(inputs.device)
        grid, whole = chosen[:, None, None, None], chosen[:, None, None, None, None]
        inputs = torch.where(whole, mirrored_inputs(inputs, mirror), inputs)
        displacement = torch.where(whole, mirrored_field(displacement, mirror), displacement)
        contact = torch.where(grid, contact.flip(2 + mirror.value), contact)
        depth = torch.where(grid, depth.flip(2 + mirror.value), depth)
    return inputs, replace(truth, displacement=displacement, contact=contact, depth=depth)


def _kind(label: MotionLabel) -> int:
    return _KINDS.index(motion_class(label.motion)) if label.is_readable else UNSEEN


def _amounts(label: MotionLabel) -> tuple[float, float]:
    """Return degrees turned and mm slid, whatever the way; NaN for what the motion is not."""
    turns, slides = (label.is_readable and label.motion in kind for kind in (ROTATIONS, SLIDES))
    return (
        abs(label.rotation_deg) if turns else math.nan,
        math.hypot(label.slide_x_mm, label.slide_y_mm) if slides else math.nan,
    )
