"""Pretrain the embedded backbone on the simulator's dense truth, then freeze it.

Patch tokens learn, through one linear map, how far the imprint moved, whether the patch is in
contact and how deep. The global token learns how much is touched, how deep, how much moves, how
far the view is magnified, which components of the motion count (turning, sliding, pressing or
letting go), and by how many degrees or pixels. No loss asks it which way it turns or slides, though
attention lets it give most of that away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.stem import (
    ALIGNED_AT,
    MAGNIFICATION_AT,
    PATCH_INPUT_DIM,
    Mirror,
    mirrored_field,
    mirrored_inputs,
)
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.vit import FrozenBackbone, ViT, ViTConfig
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.twist import Component
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.examples import Examples, Rows
from geotlm_lm.training.fit import fit, learn
from geotlm_lm.training.ranks import ALONE, Ranks
from geotlm_lm.training.truth import ClipTruth, component_truth, counts_motion, motion_loss

PEAK_RATE, WEIGHT_DECAY, WARMUP_SHARE = 1e-3, 0.05, 0.05

GLOBAL_TARGET_COUNT = 6
DEPTH_SCALE_MM = 0.3

COMPONENT_SHARE = 0.7
"""Weight of the loss that asks which components count: most wrong answers mistake one."""

AMOUNT_SHARE = 0.5
"""Weight of the loss that asks how far it turned or slid."""

AMOUNT_SCALES = (4.0, 4.0)
"""Degrees of turning and pixels of sliding from which on errors count relative to the amount: a
fifth of it or 2 degrees and 2 pixels are right in an answer."""

COMPONENT_LOGITS = 5
"""Whether a turn counts, a slide, a press, a release, and whether anything touches."""


class DenseHeads(nn.Module):
    """Linear read-outs of tokens of a width, used only while pretraining."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.patch = nn.Linear(width, 4)
        self.summary = nn.Linear(width, GLOBAL_TARGET_COUNT)
        self.components = nn.Linear(width, COMPONENT_LOGITS)
        self.amount = nn.Linear(width, len(AMOUNT_SCALES))

    @torch.no_grad()
    def start_from_alignment(self, embed: Tensor) -> None:
        """Let displacement begin as the stem's alignment of the residual, linear in the tokens.

        `embed` is what first makes a token of a patch's inputs, (width, inputs). Measured: a
        read-out that starts at random had not found a turn again after 500 steps.
        """
        back = torch.linalg.pinv(embed.double()).to(embed.dtype)
        nn.init.zeros_(self.patch.weight)
        nn.init.zeros_(self.patch.bias)
        self.patch.weight[:2] = back[ALIGNED_AT : ALIGNED_AT + 2]


@dataclass(frozen=True, eq=False)
class DenseTruth:
    """One batch of truth on the device, float32; shapes as in `Examples`.

    `counts_motion` is 1 for the clips whose displacement is a target; `components` are the wanted
    `COMPONENT_LOGITS`, NaN where nothing is asked; `amount` holds the degrees turned and pixels
    slid, (b, 2), NaN where that cannot be seen; `magnification` is what the stem tells of the view,
    (b,).
    """

    displacement: Tensor
    contact: Tensor
    depth: Tensor
    counts_motion: Tensor
    components: Tensor
    amount: Tensor
    magnification: Tensor


def pretrain(
    examples: Examples,
    *,
    preset: TrainingPreset,
    seed: int,
    folder: Path,
    first: int = 0,
    ranks: Ranks = ALONE,
    progress: Progress = silent,
) -> tuple[FrozenBackbone, DenseHeads]:
    """Train the backbone from random weights; resumes from `folder` where a run was interrupted.

    The examples before `first` are left for others to learn from.

    Returns:
        The backbone, and the linear read-outs it was trained through.
    """
    ranks.refuse_uneven(preset.pretraining_batch)
    steps = max(preset.pretraining_draws // preset.pretraining_batch, 1)
    vit, heads = _fresh(preset, seed)
    vit.to(ranks.device)
    heads.to(ranks.device)
    parameters = [*vit.parameters(), *heads.parameters()]
    optimiser = torch.optim.AdamW(parameters, PEAK_RATE, weight_decay=WEIGHT_DECAY)
    schedule = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda step: _rate(step, steps))

    def step(number: int) -> str:
        rng = generator_for(seed, "pretraining", number)
        rows = np.sort(rng.integers(first, len(examples), size=preset.pretraining_batch))
        batch = dense_batch(examples, ranks.share(rows), ranks.device)
        inputs, truth = mirrored_at_random(*batch, rng, ranks)
        with ranks.bfloat16_products():
            tokens = vit(inputs)
        tokens = Tokens(tokens.global_token.float(), tokens.patches.float())
        loss = dense_loss(tokens, heads, truth, ranks)
        whole_loss = learn(loss, optimiser, schedule, most_norm=1.0, ranks=ranks)
        return f"pretrain backbone, loss {whole_loss:.3f}"

    parts = {"vit": vit, "heads": heads, "optimiser": optimiser, "schedule": schedule}
    fit(step, steps, parts, path=folder / "backbone.pt", ranks=ranks, progress=progress)
    return FrozenBackbone(vit), heads.cpu().requires_grad_(False)


def _fresh(preset: TrainingPreset, seed: int) -> tuple[ViT, DenseHeads]:
    config = ViTConfig(
        PATCH_INPUT_DIM, preset.backbone_width, preset.backbone_depth, preset.backbone_heads
    )
    generator = torch.Generator().manual_seed(seed_for(seed, "weights", "backbone"))
    vit, heads = ViT(config).initialise(generator), DenseHeads(config.width)
    for head in (heads.summary, heads.components, heads.amount):
        nn.init.normal_(head.weight, 0, config.width**-0.5, generator=generator)
        nn.init.zeros_(head.bias)
    heads.start_from_alignment(vit.embed_one_bin())
    return vit, heads


def _rate(step: int, steps: int) -> float:
    """Warm up linearly, then fall along a half cosine to zero."""
    warmup = max(WARMUP_SHARE * steps, 1.0)
    if step < warmup:
        return (step + 1) / (warmup + 1)
    return 0.5 * (1 + float(np.cos(np.pi * (step - warmup) / max(steps - warmup, 1))))


def dense_loss(
    tokens: Tokens, heads: DenseHeads, truth: DenseTruth, ranks: Ranks = ALONE
) -> Tensor:
    """Return the pretraining loss of one batch, or of one rank's share of it."""
    shift, contact_logit, depth = heads.patch(tokens.patches).split([2, 1, 1], dim=-1)
    contact_logit, depth = contact_logit.squeeze(-1), depth.squeeze(-1)
    weight = truth.contact * truth.counts_motion[:, None, None, None]
    moved = motion_loss(shift * FLOW_SCALE_PX, truth.displacement, weight, ranks)
    contact = F.binary_cross_entropy_with_logits(contact_logit, truth.contact)
    deep = F.smooth_l1_loss(depth, truth.depth / DEPTH_SCALE_MM)
    summary = F.smooth_l1_loss(heads.summary(tokens.global_token), _summary(truth))
    counted = component_loss(heads.components(tokens.global_token), truth.components, ranks)
    amount = amount_loss(heads.amount(tokens.global_token), truth.amount, ranks)
    return (
        moved + contact + 0.3 * deep + summary + COMPONENT_SHARE * counted + AMOUNT_SHARE * amount
    )


def component_loss(logits: Tensor, wanted: Tensor, ranks: Ranks = ALONE) -> Tensor:
    """Return the mean cross entropy of what is asked for, (b, COMPONENT_LOGITS); NaN is not."""
    is_asked = ~wanted.isnan()
    losses = F.binary_cross_entropy_with_logits(logits, wanted.nan_to_num(), reduction="none")
    return (losses * is_asked).sum() / ranks.asked_per_rank(is_asked) * COMPONENT_LOGITS


def amount_loss(amounts: Tensor, true: Tensor, ranks: Ranks = ALONE) -> Tensor:
    """Return the mean error of the amounts there are, each on a scale that bends to a logarithm.

    Both are degrees turned and pixels slid, (b, 2); true ones are NaN where there is none.
    """
    is_asked = ~true.isnan()
    scaled = torch.log1p(true.nan_to_num() / true.new_tensor(AMOUNT_SCALES))
    errors = F.smooth_l1_loss(amounts, scaled, reduction="none", beta=0.1)
    return (errors * is_asked).sum() / ranks.asked_per_rank(is_asked)


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

    def moved(values: Rows) -> Tensor:
        return torch.from_numpy(values[rows]).to(device).float()

    labels = [examples.labels[row] for row in rows]
    counts = np.array([counts_motion(label) for label in labels], dtype=np.float32)
    truths = [component_truth(label) for label in labels]
    inputs = moved(examples.inputs)
    truth = DenseTruth(
        displacement=moved(examples.displacement_px),
        contact=moved(examples.contact),
        depth=moved(examples.depth_mm),
        counts_motion=torch.from_numpy(counts).to(device),
        components=torch.tensor([_wanted(truth) for truth in truths], device=device),
        amount=torch.tensor([_amounts(truth) for truth in truths], device=device),
        magnification=inputs[:, 0, 0, 0, MAGNIFICATION_AT],
    )
    return inputs, truth


def mirrored_at_random(
    inputs: Tensor, truth: DenseTruth, rng: np.random.Generator, ranks: Ranks = ALONE
) -> tuple[Tensor, DenseTruth]:
    """Return a rank's share of which each mirror, drawn on its own, shows half: four looks a clip.

    Of clips it had been pretrained on a backbone without this told the kind of motion at 0.973, of
    others of the same objects at 0.948.
    """
    displacement, contact, depth = truth.displacement, truth.contact, truth.depth
    for mirror in Mirror:
        drawn = ranks.share(rng.random(ranks.count * len(inputs)) < 0.5)
        chosen = torch.from_numpy(drawn).to(inputs.device)
        grid, whole = chosen[:, None, None, None], chosen[:, None, None, None, None]
        inputs = torch.where(whole, mirrored_inputs(inputs, mirror), inputs)
        displacement = torch.where(whole, mirrored_field(displacement, mirror), displacement)
        contact = torch.where(grid, contact.flip(2 + mirror.value), contact)
        depth = torch.where(grid, depth.flip(2 + mirror.value), depth)
    return inputs, replace(truth, displacement=displacement, contact=contact, depth=depth)


def _wanted(truth: ClipTruth) -> tuple[float, ...]:
    """Return the wanted logits' answers, NaN where nothing is asked."""

    def number(is_so: bool | None) -> float:
        return math.nan if is_so is None else float(is_so)

    press, inward = truth.moves[Component.PRESS], truth.twist.inward_mm > 0
    return (
        number(truth.moves[Component.TURN]),
        number(truth.moves[Component.SLIDE]),
        number(press if press is None else press and inward),
        number(press if press is None else press and not inward),
        float(truth.is_touched),
    )


def _amounts(truth: ClipTruth) -> tuple[float, float]:
    """Return degrees turned and pixels slid, whatever the way; NaN for what cannot be seen."""
    sizes = abs(truth.twist.turn_deg), truth.twist.slide_px
    readable = (truth.is_readable[part] for part in (Component.TURN, Component.SLIDE))
    return tuple(size if seen else math.nan for size, seen in zip(sizes, readable, strict=True))
