"""Train DGR and the linear probe on frozen tokens, in two ways.

`paper`: only the classification loss shapes shear and mask. `grounded`: the simulator's true change
of displacement and contact supervise them as well, so that the drawn shear field is physical.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.dgr.encoder import DGR, Geometry
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.training.config import DGRMode
from geotlm_lm.training.fit import Best, fit_epochs
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

    @classmethod
    def joined(cls, parts: Sequence[TokenSet]) -> TokenSet:
        """Return several sets, one behind the other."""
        names = ("global_token", "patches")
        tokens = (torch.cat([getattr(part.tokens, name) for part in parts]) for name in names)
        columns = {name: [vars(part)[name] for part in parts] for name in list(vars(parts[0]))[1:]}
        rest = {k: None if own[0] is None else torch.cat(own) for k, own in columns.items()}
        return cls(Tokens(*tokens), **rest)

    def only(self, rows: Any) -> TokenSet:
        """Return some of the clips."""
        rest = {k: None if own is None else own[rows] for k, own in list(vars(self).items())[1:]}
        tokens = Tokens(self.tokens.global_token[rows], self.tokens.patches[rows])
        return TokenSet(tokens, **rest)


class TokenReader(nn.Module):
    """DGR, or none, and a linear probe (Eqs. 2-9) of tokens standardised by those it learns from.

    Args:
        train: What it learns from; nothing else shapes the statistics.
        labels: The motions it tells apart.
        dgr: Of the tokens' widths; None for a probe on the global token alone.
        generator: Draws the weights.
    """

    def __init__(
        self,
        train: TokenSet,
        labels: Sequence[Motion],
        dgr: DGR | None,
        generator: torch.Generator,
    ) -> None:
        super().__init__()
        tokens = train.tokens
        self.global_standardiser = Standardiser.fit(tokens.global_token.float())
        self.patch_standardiser = None if dgr is None else _patch_standardiser(tokens)
        self.dgr, self.probe = dgr, LinearProbe(tokens.global_token.shape[-1], labels)
        self.columns = torch.full((len(ALL_MOTIONS),), -1)
        for column, label in enumerate(labels):
            self.columns[ALL_MOTIONS.index(label)] = column
        for layer in self.modules():
            if isinstance(layer, nn.Linear):
                nn.init.normal_(layer.weight, 0, layer.in_features**-0.5, generator=generator)
                nn.init.zeros_(layer.bias)

    def forward(self, data: TokenSet, rows: Any) -> tuple[Tensor, Geometry | None]:
        """Return logits and geometry of some rows; patches are read only where there is DGR."""
        device = self.probe.head.weight.device
        token = self.global_standardiser.apply(data.tokens.global_token[rows].float()).to(device)
        if self.dgr is None:
            return self.probe(token), None
        patches = self.patch_standardiser.apply(data.tokens.patches[rows].float())
        geometry = self.dgr(patches.to(device))
        return self.probe(token + geometry.feature), geometry

    def wanted(self, data: TokenSet, rows: Any = slice(None)) -> Tensor:
        """Return the columns of the true motions of some rows."""
        return self.columns[data.motions[rows]]

    def loss(self, logits: Tensor, data: TokenSet, rows: Tensor) -> Tensor:
        """Return the mean cross entropy of readable clips; 0, not NaN, for a batch without any."""
        readable = data.is_readable[rows].to(logits.device)
        wanted = self.wanted(data, rows).to(logits.device)
        losses = F.cross_entropy(logits, wanted, reduction="none")
        return losses[readable].sum() / readable.sum().clamp(min=1)

    @torch.no_grad()
    def logits(self, data: TokenSet) -> Tensor:
        """Return the logits of every row."""
        starts = range(0, len(data.tokens), 256)
        return torch.cat([self(data, slice(start, start + 256))[0].cpu() for start in starts])


def train_reader(
    reader: TokenReader,
    train: TokenSet,
    score: Callable[[], float | tuple[float, ...]],
    order: Sequence[str | int],
    *,
    mode: DGRMode = "paper",
    epochs: int,
    seed: int,
    device: str = "cpu",
    **kept: Any,
) -> Best:
    """Train a reader in place, and leave it with the weights of the epoch of the best `score`.

    `order` names the draws of the order of rows; `kept` is `name`, `path`, `about` and `progress`
    of `fit_epochs`.
    """
    count = len(train.tokens)

    def loss(rows: Tensor) -> Tensor:
        logits, geometry = reader(train, rows)
        readable = reader.loss(logits, train, rows)
        return readable + (grounding_loss(geometry, train, rows) if mode == "grounded" else 0)

    reader.to(device)
    groups = [{"params": list(reader.probe.parameters()), "lr": HEAD_RATE}]
    if reader.dgr is not None:
        groups.append({"params": list(reader.dgr.parameters()), "lr": DGR_RATE})
    best = fit_epochs(
        reader,
        torch.optim.AdamW(groups, weight_decay=WEIGHT_DECAY),
        loss,
        score,
        count=count,
        batch=BATCH,
        epochs=epochs,
        order=lambda epoch: generator_for(seed, *order, epoch).permutation(count),
        **kept,
    )
    reader.cpu()
    return best


def halved(tokens: Tokens) -> Tokens:
    """Return tokens with those of patches in half precision.

    Raises:
        UsageError: If they do not fit it.
    """
    patches = tokens.patches.half()
    if not bool(torch.isfinite(patches).all() and torch.isfinite(tokens.global_token).all()):
        raise UsageError(
            f"tokens up to {float(tokens.patches.abs().max()):.3g} were found, expected below "
            f"65504; the weights are not those of a trained encoder."
        )
    return Tokens(tokens.global_token, patches, tokens.views)


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
) -> tuple[TokenReader, float]:
    """Train DGR and the probe on `train`; keep the epoch that is best on `validation`.

    The standardisers see nothing but `train`; the objects of `validation` are others. Grounded
    shear and mask start from the read-outs, the same linear maps to displacement and contact, that
    the backbone was pretrained through; None will do for `paper`. Also returned is the accuracy on
    `validation`.
    """
    dgr = DGR(train.tokens.patches.shape[-1], train.tokens.global_token.shape[-1])
    reader = TokenReader(train, ALL_MOTIONS, dgr, _weights(seed, "dgr"))
    if mode == "grounded":
        _start_from(read_outs, reader)
    best = train_reader(
        reader,
        train,
        lambda: _task_accuracy(reader.logits(validation), validation),
        ("dgr", mode),
        mode=mode,
        epochs=epochs,
        seed=seed,
        device=device,
        name=f"train DGR ({mode})",
        path=path,
        about={"token_mean": reader.global_standardiser.mean.tolist()},
        progress=progress,
    )
    return reader, best.score


def train_global_probe(
    train: TokenSet, validation: TokenSet, *, epochs: int, seed: int
) -> LinearProbe:
    """Train the same read-out on the global token alone, without DGR: the controlled ablation."""
    reader = TokenReader(train, ALL_MOTIONS, None, _weights(seed, "global_probe"))
    train_reader(
        reader,
        train,
        lambda: _task_accuracy(reader.logits(validation), validation),
        ("global_probe",),
        epochs=epochs,
        seed=seed,
    )
    return reader.probe


def _weights(seed: int, name: str) -> torch.Generator:
    return torch.Generator().manual_seed(seed_for(seed, "weights", name))


@torch.no_grad()
def _start_from(read_outs: DenseHeads, model: TokenReader) -> None:
    """Copy the backbone's read-outs into shear and mask, which see standardised tokens."""
    mean, scale = model.patch_standardiser.mean, model.patch_standardiser.scale
    shift, contact = read_outs.patch.weight[:2], read_outs.patch.weight[2:3]
    offset = read_outs.patch.bias
    model.dgr.to_shear.weight.copy_(shift * scale)
    model.dgr.to_shear.bias.copy_(offset[:2] + shift @ mean)
    model.dgr.to_mask.weight.copy_(contact * scale)
    model.dgr.to_mask.bias.copy_(offset[2:3] + contact @ mean)


def _patch_standardiser(tokens: Tokens) -> Standardiser:
    """Fit the statistics of the patch tokens, pooled over the grid."""
    per_clip = tokens.patches[0, ..., 0].numel()
    patches = tokens.patches[:: max(len(tokens) // max(MOST_PATCHES // per_clip, 1), 1)]
    return Standardiser.fit(patches.reshape(-1, patches.shape[-1]).float())


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
