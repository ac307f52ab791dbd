"""The paper's protocol: folds in which no object stands on two sides, and a small read-out on each.

The validation part of a fold exists so that the best epoch is never chosen on the held-out objects.
Every recipe sees the same tokens, standardised on training, in the same order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import Labels, generator_for, group_codes, seed_for
from geotlm_lm.dgr.ablations import AblatedDGR, DGRParts
from geotlm_lm.training.config import DGRMode
from geotlm_lm.training.geometry import TokenReader, TokenSet, train_reader

VALIDATION_SHARE = 0.15

RIDGE = 1e-3
"""Added to the tokens' covariance, relative to its mean diagonal: tokens are nearly collinear."""

CONTACT_LOGITS = 4.0
"""Logit between no contact and full contact at the start: masks of 0.12 and 0.88."""

Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Fold:
    """Row numbers of one fold: to fit on, to choose the epoch on, and to report.

    The objects of `test`, `held_out`, are in neither of the others.
    """

    train: Rows
    val: Rows
    test: Rows
    held_out: tuple[str, ...]


def object_folds(objects: Labels, fold_count: int, *, seed: int) -> list[Fold]:
    """Deal the objects of rows into folds of nearly equal object count; each is held out once.

    Of the objects not held out `VALIDATION_SHARE` become validation objects, at least one.
    """
    codes, names = group_codes(objects)
    if not 2 <= fold_count <= len(names) or len(names) < 3:
        raise ValueError(
            f"{fold_count} folds of three disjoint parts need at least {max(fold_count, 3)} "
            f"objects, and at least 2 folds; found {len(names)} objects"
        )
    order = generator_for(seed, "folds").permutation(len(names))
    return list(_folds(codes, names, np.array_split(order, fold_count), seed))


def leave_one_object_out(objects: Labels, *, seed: int) -> list[Fold]:
    """Hold out each object once, in order of first appearance."""
    codes, names = group_codes(objects)
    if len(names) < 3:
        raise ValueError(f"three disjoint parts need at least 3 objects; found {len(names)}")
    parts = [np.array([number]) for number in range(len(names))]
    return list(_folds(codes, names, parts, seed))


def _folds(codes: Rows, names: list, parts: list[Rows], seed: int) -> Iterator[Fold]:
    everything = np.arange(len(names))
    for number, test in enumerate(parts):
        rest = np.setdiff1d(everything, test)
        rest = generator_for(seed, "validation", number).permutation(rest)
        # One object stays for training and one for validation, whatever the share.
        val_count = min(max(1, round(VALIDATION_SHARE * len(rest))), len(rest) - 1)
        if val_count < 1:
            raise ValueError("a fold leaves fewer than two objects for training and validation")
        val, train = rest[:val_count], rest[val_count:]
        yield Fold(
            train=np.flatnonzero(np.isin(codes, train)),
            val=np.flatnonzero(np.isin(codes, val)),
            test=np.flatnonzero(np.isin(codes, test)),
            held_out=tuple(str(names[number]) for number in test),
        )


@dataclass(frozen=True)
class Recipe:
    """What is trained on a fold's tokens."""

    parts: DGRParts | None = None  # the parts of DGR; None for the probe on the global token alone
    # Which losses shape DGR; `grounded` needs the mask, and rows with their truth.
    mode: DGRMode = "paper"


@dataclass(frozen=True)
class FoldOutcome:
    """What one recipe came to on one fold: the motions of its test rows, by the epoch kept."""

    predictions: tuple[Motion, ...]
    best_epoch: int
    validation_accuracy: float
    parameters: int


def train_on_fold(
    data: TokenSet,
    fold: Fold,
    labels: tuple[Motion, ...],
    recipe: Recipe,
    *,
    epochs: int,
    seed: int,
) -> FoldOutcome:
    """Train a recipe and name the motion of every test row by its best validation epoch.

    Best is the highest accuracy on the validation rows, and among equals the least loss: with few
    objects to validate on many epochs are equally accurate.

    Every row's motion is one of `labels`. The paper takes 30 epochs.
    """
    train, val, test = map(data.only, (fold.train, fold.val, fold.test))
    widths = train.tokens.patches.shape[-1], train.tokens.global_token.shape[-1]
    dgr = None if recipe.parts is None else AblatedDGR(*widths, recipe.parts)
    weights = torch.Generator().manual_seed(seed_for(seed, "weights", "fold"))
    reader = TokenReader(train, labels, dgr, weights)
    if recipe.mode == "grounded":
        initialise_from_truth(reader, train)
    best = train_reader(
        reader,
        train,
        lambda: score(reader, val),
        ("fold",),
        mode=recipe.mode,
        epochs=epochs,
        seed=seed,
    )
    return FoldOutcome(
        predictions=tuple(labels[index] for index in reader.logits(test).argmax(dim=-1).tolist()),
        best_epoch=best.epoch,
        validation_accuracy=best.score[0],
        parameters=sum(parameter.numel() for parameter in reader.parameters()),
    )


def score(reader: TokenReader, data: TokenSet) -> tuple[float, float]:
    """Return accuracy and negative loss, so that the greater is the better."""
    logits, truth = reader.logits(data), reader.wanted(data)
    accuracy = (logits.argmax(dim=-1) == truth).float().mean()
    return float(accuracy), -float(F.cross_entropy(logits, truth))


@torch.no_grad()
def initialise_from_truth(reader: TokenReader, train: TokenSet) -> None:
    """Set shear and mask to the linear maps that come nearest to the truth of the training rows.

    The change of shear is fitted to the true change of displacement where there is contact, the
    mask's logit to the true contact. The bundle's own DGR starts from the read-outs its backbone
    was pretrained through; they are not kept with the weights, and encoders of others had none.
    """
    dgr, contact = reader.dgr, train.contact.float()
    patches = reader.patch_standardiser.apply(train.tokens.patches.float())
    counted = contact * train.counts_motion.float()[:, None, None]
    change = train.shear_change.float() / FLOW_SCALE_PX
    shear, _ = _nearest(patches[:, 1] - patches[:, 0], change, counted, has_offset=False)
    mask, offset = _nearest(
        patches.mean(dim=1),
        CONTACT_LOGITS * (contact - 0.5)[..., None],
        torch.ones_like(contact),
        has_offset=True,
    )
    dgr.to_shear.weight.copy_(shear.T)
    dgr.to_shear.bias.zero_()
    dgr.to_mask.weight.copy_(mask.T)
    dgr.to_mask.bias.copy_(offset)


def _nearest(
    features: Tensor, targets: Tensor, weight: Tensor, *, has_offset: bool
) -> tuple[Tensor, Tensor]:
    """Return the weighted ridge regression of targets (..., c) on features: map and offset."""
    width = features.shape[-1]
    gram = torch.zeros(width + 1, width + 1, dtype=torch.float64)
    product = torch.zeros(width + 1, targets.shape[-1], dtype=torch.float64)
    # Clip by clip batches: all patches of a thousand clips in double precision would fill memory.
    for rows in torch.arange(len(features)).split(64):
        x = features[rows].reshape(-1, width)
        x = torch.nn.functional.pad(x, (0, 1), value=float(has_offset))
        weighted = x * weight[rows].reshape(-1, 1)
        gram += (weighted.T @ x).double()
        product += (weighted.T @ targets[rows].reshape(len(x), -1)).double()
    ridge = RIDGE * float(gram.diagonal()[:width].mean()) + 1e-9
    solution = torch.linalg.solve(gram + ridge * torch.eye(width + 1, dtype=torch.float64), product)
    return solution[:width].float(), solution[width].float()
