"""The paper's protocol on one fold: frozen tokens, standardised on training, a small read-out.

Every recipe sees the same standardised tokens in the same order; nothing here knows how a fold was
drawn or what is made of its predictions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.dgr.ablations import AblatedDGR, DGRParts
from geotlm_lm.dgr.encoder import Geometry
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.training.config import DGRMode
from geotlm_lm.training.geometry import (
    ALL_MOTIONS,
    BATCH,
    DGR_RATE,
    HEAD_RATE,
    WEIGHT_DECAY,
    TokenSet,
    fit_standardisers,
    grounding_loss,
)
from geotlm_lm.training.least_squares_start import initialise_from_truth
from geotlm_lm.training.object_folds import Fold, Rows

PREDICT_BATCH = 256


@dataclass(frozen=True)
class Recipe:
    """What is trained on a fold's tokens.

    Args:
        parts: The parts of DGR; None for the probe on the global token alone.
        mode: Which losses shape DGR; `grounded` needs the mask, and rows with their truth.
    """

    parts: DGRParts | None = None
    mode: DGRMode = "paper"


@dataclass(frozen=True)
class FoldOutcome:
    """What one recipe came to on one fold.

    Args:
        predictions: The motion named for each test row.
        best_epoch: The epoch that was kept, counted from 1.
        validation_accuracy: Accuracy of that epoch on the validation rows.
        parameters: How many numbers were trained.
    """

    predictions: tuple[Motion, ...]
    best_epoch: int
    validation_accuracy: float
    parameters: int


@dataclass(frozen=True, eq=False)
class StandardisedFold:
    """The three parts of a fold in float32, standardised with the statistics of the first."""

    train: TokenSet
    val: TokenSet
    test: TokenSet
    global_standardiser: Standardiser
    patch_standardiser: Standardiser


def standardise_fold(data: TokenSet, fold: Fold) -> StandardisedFold:
    """Cut a set of tokens into a fold's parts; only the training rows shape the statistics."""
    parts = [_rows_of(data, rows) for rows in (fold.train, fold.val, fold.test)]
    standardisers = fit_standardisers(parts[0].tokens)
    whole, patchwise = standardisers
    ready = [
        replace(
            part,
            tokens=Tokens(
                whole.apply(part.tokens.global_token.float()),
                patchwise.apply(part.tokens.patches.float()),
            ),
        )
        for part in parts
    ]
    return StandardisedFold(*ready, *standardisers)


def train_on_fold(
    fold: StandardisedFold,
    labels: tuple[Motion, ...],
    recipe: Recipe,
    *,
    epochs: int,
    seed: int,
) -> FoldOutcome:
    """Train a recipe and name the motion of every test row by its best validation epoch.

    Best is the highest accuracy on the validation rows, and among equals the least loss: with few
    objects to validate on many epochs are equally accurate.

    Args:
        fold: The tokens.
        labels: The motions to tell apart; every row's motion is one of them.
        recipe: What is trained.
        epochs: Epochs over the training rows, at least one (paper: 30).
        seed: Root of the first weights and of the order of the rows.
    """
    if recipe.parts is None:
        fold = _without_patches(fold)
    reader = _Reader(fold.train.tokens, labels, recipe, seed)
    if recipe.mode == "grounded":
        initialise_from_truth(reader.dgr, fold.train)
    optimiser = torch.optim.AdamW(reader.rates(), weight_decay=WEIGHT_DECAY)
    best: tuple[tuple[float, float], int, dict[str, Tensor]] | None = None
    for epoch in range(epochs):
        order = generator_for(seed, "fold", epoch).permutation(len(fold.train.tokens))
        for rows in torch.from_numpy(order).split(BATCH):
            loss = reader.loss(_rows_of(fold.train, rows))
            optimiser.zero_grad(set_to_none=True)
            loss.backward()
            optimiser.step()
        score = reader.score(fold.val)
        if best is None or score > best[0]:
            best = score, epoch + 1, {k: v.clone() for k, v in reader.state_dict().items()}
    (accuracy, _), best_epoch, state = best
    reader.load_state_dict(state)
    found = reader.logits(fold.test).argmax(dim=-1)
    return FoldOutcome(
        predictions=tuple(labels[index] for index in found.tolist()),
        best_epoch=best_epoch,
        validation_accuracy=accuracy,
        parameters=sum(parameter.numel() for parameter in reader.parameters()),
    )


class _Reader(nn.Module):
    """DGR where the recipe has one, and a linear probe (Eqs. 2-9)."""

    def __init__(
        self, tokens: Tokens, labels: tuple[Motion, ...], recipe: Recipe, seed: int
    ) -> None:
        super().__init__()
        self.recipe = recipe
        width, patch_width = tokens.global_token.shape[-1], tokens.patches.shape[-1]
        self.dgr = None if recipe.parts is None else AblatedDGR(patch_width, width, recipe.parts)
        self.probe = LinearProbe(width, labels)
        self.columns = torch.full((len(ALL_MOTIONS),), -1)
        for column, label in enumerate(labels):
            self.columns[ALL_MOTIONS.index(label)] = column
        generator = torch.Generator().manual_seed(seed_for(seed, "weights", "fold"))
        for layer in self.modules():
            if isinstance(layer, nn.Linear):
                nn.init.normal_(layer.weight, 0, layer.in_features**-0.5, generator=generator)
                nn.init.zeros_(layer.bias)

    def rates(self) -> list[dict]:
        """Return the parameters with their learning rates (paper, implementation details)."""
        groups = [{"params": list(self.probe.parameters()), "lr": HEAD_RATE}]
        if self.dgr is not None:
            groups.append({"params": list(self.dgr.parameters()), "lr": DGR_RATE})
        return groups

    def forward(self, tokens: Tokens) -> tuple[Tensor, Geometry | None]:
        if self.dgr is None:
            return self.probe(tokens.global_token), None
        geometry = self.dgr(tokens.patches)
        return self.probe(tokens.global_token + geometry.feature), geometry

    def loss(self, batch: TokenSet) -> Tensor:
        """Return the training loss of a batch."""
        logits, geometry = self(batch.tokens)
        loss = F.cross_entropy(logits, self.columns[batch.motions])
        if self.recipe.mode == "grounded":
            loss = loss + grounding_loss(geometry, batch, slice(None))
        return loss

    @torch.no_grad()
    def logits(self, part: TokenSet) -> Tensor:
        """Return the logits of every row."""
        starts = range(0, len(part.tokens), PREDICT_BATCH)
        slices = (slice(start, start + PREDICT_BATCH) for start in starts)
        return torch.cat([self(_tokens_of(part.tokens, rows))[0] for rows in slices])

    def score(self, part: TokenSet) -> tuple[float, float]:
        """Return accuracy and negative loss, so that the greater is the better."""
        logits, truth = self.logits(part), self.columns[part.motions]
        accuracy = (logits.argmax(dim=-1) == truth).float().mean()
        return float(accuracy), -float(F.cross_entropy(logits, truth))


def _without_patches(fold: StandardisedFold) -> StandardisedFold:
    """Return the fold without its patch tokens: what nobody reads need not be gathered."""

    def bare(part: TokenSet) -> TokenSet:
        whole = part.tokens.global_token
        return replace(part, tokens=Tokens(whole, whole[:, :0]))

    return replace(fold, train=bare(fold.train), val=bare(fold.val), test=bare(fold.test))


def _tokens_of(tokens: Tokens, rows: Rows | Tensor | slice) -> Tokens:
    return Tokens(tokens.global_token[rows], tokens.patches[rows])


def _rows_of(data: TokenSet, rows: Rows | Tensor | slice) -> TokenSet:
    def pick(values: Tensor | None) -> Tensor | None:
        return None if values is None else values[rows]

    return TokenSet(
        tokens=_tokens_of(data.tokens, rows),
        shear_change=pick(data.shear_change),
        contact=pick(data.contact),
        motions=data.motions[rows],
        is_readable=data.is_readable[rows],
        counts_motion=data.counts_motion[rows],
    )
