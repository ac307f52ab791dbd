"""Train DGR and the linear probe on frozen tokens, in two ways.

`paper`: only the classification loss shapes shear and mask. `grounded`: the simulator's true change
of displacement and contact supervise them as well, so that the drawn shear field is physical.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.dgr.encoder import DGR, Geometry
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.training.config import DGRMode
from geotlm_lm.training.fit import fit_epochs
from geotlm_lm.training.pretraining import DenseHeads
from geotlm_lm.training.truth import counts_motion, motion_loss

HEAD_RATE, DGR_RATE, WEIGHT_DECAY, BATCH = 1e-3, 3e-4, 0.01, 32
"""Paper, implementation details."""

ALL_MOTIONS = tuple(Motion)

MOST_PATCHES = 1000 * 392
"""Patch tokens whose statistics are taken: a thousand clips of 2 x 14 x 14."""

EQUAL_ACCURACY = 0.01
"""Lead in validation accuracy that says nothing: one and a half standard errors of the 600 clips
that turn or slide."""


@dataclass(frozen=True, eq=False)
class TokenSet:
    """Tokens of clips with the truth that shapes DGR."""

    tokens: Tokens  # frozen backbone's tokens, unstandardised, float16 or float32
    # True change of displacement between the bins, px, shape (n, 14, 14, 2); None where only the
    # classification loss shapes DGR.
    shear_change: Tensor | None
    contact: Tensor | None  # true contact, mean over bins, shape (n, 14, 14); None likewise
    motions: Tensor  # index into `ALL_MOTIONS`, shape (n,)
    is_readable: Tensor  # whether the motion leaves a trace, bool, shape (n,)
    counts_motion: Tensor  # whether the shear change is a target, bool, shape (n,)

    @classmethod
    def of(
        cls,
        tokens: Tokens,
        labels: Sequence[MotionLabel],
        shear_change: Tensor | None = None,
        contact: Tensor | None = None,
    ) -> TokenSet:
        """Lay the truth of labels beside the tokens of their clips."""
        return cls(
            tokens=tokens,
            shear_change=shear_change,
            contact=contact,
            motions=torch.tensor([ALL_MOTIONS.index(label.motion) for label in labels]),
            is_readable=torch.tensor([label.is_readable for label in labels]),
            counts_motion=torch.tensor([counts_motion(label) for label in labels]),
        )


@dataclass(eq=False)
class GeometryModel:
    """What one training of DGR yields."""

    global_standardiser: Standardiser
    patch_standardiser: Standardiser
    dgr: DGR
    probe: LinearProbe
    validation_accuracy: float


def better_mode(accuracies: Mapping[str, float]) -> DGRMode:
    """Return the mode that answers better; between equals the one whose shear is physical."""
    lead = accuracies["paper"] - accuracies["grounded"]
    return "paper" if lead > EQUAL_ACCURACY else "grounded"


def train_geometry(
    train: TokenSet,
    validation: TokenSet,
    *,
    mode: DGRMode,
    read_outs: DenseHeads | None,
    epochs: int,
    seed: int,
    path: Path,
    device: str = "cpu",
    progress: Progress = silent,
) -> GeometryModel:
    """Train DGR and the probe on `train`; keep the epoch that is best on `validation`.

    The standardisers see nothing but `train`; the objects of `validation` are others. Grounded
    shear and mask start from the read-outs, the same linear maps to displacement and contact, that
    the backbone was pretrained through; None will do for `paper`.
    """
    width, count = train.tokens.global_token.shape[-1], len(train.tokens)
    dgr, probe = DGR(train.tokens.patches.shape[-1], width), LinearProbe(width, ALL_MOTIONS)
    generator = torch.Generator().manual_seed(seed_for(seed, "weights", "dgr"))
    for layer in (dgr.to_shear, dgr.to_mask, dgr.to_feature, probe.head):
        nn.init.normal_(layer.weight, 0, layer.in_features**-0.5, generator=generator)
        nn.init.zeros_(layer.bias)
    model = GeometryModel(*fit_standardisers(train.tokens), dgr, probe, -1.0)
    if mode == "grounded":
        _start_from(read_outs, model)
    dgr.to(device)
    probe.to(device)
    groups = [
        {"params": list(dgr.parameters()), "lr": DGR_RATE},
        {"params": list(probe.parameters()), "lr": HEAD_RATE},
    ]

    def loss(rows: Tensor) -> Tensor:
        logits, geometry = _forward(model, train, rows)
        readable = _readable_loss(logits, train, rows)
        return readable + (grounding_loss(geometry, train, rows) if mode == "grounded" else 0)

    best = fit_epochs(
        nn.ModuleDict({"dgr": dgr, "probe": probe}),
        torch.optim.AdamW(groups, weight_decay=WEIGHT_DECAY),
        loss,
        lambda: readable_accuracy(model, validation),
        count=count,
        batch=BATCH,
        epochs=epochs,
        order=lambda epoch: generator_for(seed, "dgr", mode, epoch).permutation(count),
        name=f"train DGR ({mode})",
        path=path,
        about={"token_mean": model.global_standardiser.mean.tolist()},
        progress=progress,
    )
    dgr.cpu()
    probe.cpu()
    model.validation_accuracy = best.score
    return model


@torch.no_grad()
def _start_from(read_outs: DenseHeads, model: GeometryModel) -> None:
    """Copy the backbone's read-outs into shear and mask, which see standardised tokens."""
    mean, scale = model.patch_standardiser.mean, model.patch_standardiser.scale
    shift, contact = read_outs.patch.weight[:2], read_outs.patch.weight[2:3]
    offset = read_outs.patch.bias
    model.dgr.to_shear.weight.copy_(shift * scale)
    model.dgr.to_shear.bias.copy_(offset[:2] + shift @ mean)
    model.dgr.to_mask.weight.copy_(contact * scale)
    model.dgr.to_mask.bias.copy_(offset[2:3] + contact @ mean)


def fit_standardisers(tokens: Tokens) -> tuple[Standardiser, Standardiser]:
    """Fit the statistics of the global token and of the patch tokens, pooled over the grid."""
    per_clip = tokens.patches[0, ..., 0].numel()
    patches = tokens.patches[:: max(len(tokens) // max(MOST_PATCHES // per_clip, 1), 1)]
    return (
        Standardiser.fit(tokens.global_token.float()),
        Standardiser.fit(patches.reshape(-1, patches.shape[-1]).float()),
    )


def train_global_probe(
    train: TokenSet, validation: TokenSet, standardiser: Standardiser, *, epochs: int, seed: int
) -> LinearProbe:
    """Train the same read-out on the global token alone, without DGR: the controlled ablation."""
    tokens = standardiser.apply(train.tokens.global_token.float())
    probe = LinearProbe(tokens.shape[-1], ALL_MOTIONS)
    generator = torch.Generator().manual_seed(seed_for(seed, "weights", "global_probe"))
    nn.init.normal_(probe.head.weight, 0, tokens.shape[-1] ** -0.5, generator=generator)
    nn.init.zeros_(probe.head.bias)
    held_out = standardiser.apply(validation.tokens.global_token.float())
    fit_epochs(
        probe,
        torch.optim.AdamW(probe.parameters(), HEAD_RATE, weight_decay=WEIGHT_DECAY),
        lambda rows: _readable_loss(probe(tokens[rows]), train, rows),
        torch.no_grad()(lambda: _task_accuracy(probe(held_out), validation)),
        count=len(tokens),
        batch=BATCH,
        epochs=epochs,
        order=lambda epoch: generator_for(seed, "global_probe", epoch).permutation(len(tokens)),
    )
    return probe


@torch.no_grad()
def readable_accuracy(model: GeometryModel, data: TokenSet) -> float:
    """Return the probe's accuracy on readable turns and slides; see `_task_accuracy`."""
    logits = []
    for start in range(0, len(data.tokens), 256):
        logits.append(_forward(model, data, slice(start, start + 256))[0].cpu())
    return _task_accuracy(torch.cat(logits), data)


def _task_accuracy(logits: Tensor, data: TokenSet) -> float:
    """Return the mean accuracy of the paper's two tasks, each among its own motions."""
    accuracies = []
    for task in (ROTATIONS, SLIDES):
        columns = torch.tensor([ALL_MOTIONS.index(motion) for motion in task])
        rows = data.is_readable & torch.isin(data.motions, columns)
        if rows.any():
            chosen = columns[logits[rows][:, columns].argmax(dim=-1)]
            accuracies.append(float((chosen == data.motions[rows]).float().mean()))
    return sum(accuracies) / max(len(accuracies), 1)


def _readable_loss(logits: Tensor, data: TokenSet, rows: Tensor) -> Tensor:
    """Return the mean cross entropy of readable clips; 0, not NaN, for a batch without any."""
    readable = data.is_readable[rows].to(logits.device)
    losses = F.cross_entropy(logits, data.motions[rows].to(logits.device), reduction="none")
    return losses[readable].sum() / readable.sum().clamp(min=1)


def _forward(model: GeometryModel, data: TokenSet, rows) -> tuple[Tensor, Geometry]:
    patches = model.patch_standardiser.apply(data.tokens.patches[rows].float())
    global_token = model.global_standardiser.apply(data.tokens.global_token[rows].float())
    device = model.probe.head.weight.device
    geometry = model.dgr(patches.to(device))
    return model.probe(global_token.to(device) + geometry.feature), geometry


def grounding_loss(geometry: Geometry, data: TokenSet, rows) -> Tensor:
    """Hold shear change to the true displacement change, and the mask to the true contact."""
    stated_px = geometry.shear_change * FLOW_SCALE_PX
    contact, change, counts_motion = (
        values[rows].to(stated_px.device).float()
        for values in (data.contact, data.shear_change, data.counts_motion)
    )
    weight = contact * counts_motion[:, None, None]
    shear_loss = motion_loss(stated_px, change, weight)
    mask = geometry.mask.clamp(1e-6, 1 - 1e-6)
    return shear_loss + F.binary_cross_entropy(mask, contact)
