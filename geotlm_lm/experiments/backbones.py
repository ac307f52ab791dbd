"""Backbones of several sizes, pretrained alike: what error buys what run time.

All see the same simulated clips for the same steps, fewer than the shipped one, and are judged by
their own linear read-outs on everyday objects that no weight has seen. What compares is the rows
with each other, not with the shipped model.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.backbone.frozen import ENCODE_BATCH, FrozenBackbone
from geotlm_lm.backbone.stem import FLOW_SCALE_PX
from geotlm_lm.core.record import RunRecord
from geotlm_lm.evaluation.answers import within_tolerance
from geotlm_lm.experiments.evaluate import one_thread
from geotlm_lm.experiments.sizes import simulated_sets
from geotlm_lm.training.config import DEFAULT, TrainingPreset
from geotlm_lm.training.dense import UNSEEN, DenseHeads, DenseTruth, amounts_told, dense_batch
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.pretraining import PRETRAINING_VERSION, pretrain


@dataclass(frozen=True)
class BackboneSize:
    """Sizes of a transformer.

    Args:
        width: Of a token.
        depth: Blocks.
        heads: Attention heads.
    """

    width: int
    depth: int
    heads: int


SHIPPED = BackboneSize(DEFAULT.backbone_width, DEFAULT.backbone_depth, DEFAULT.backbone_heads)

BACKBONES: dict[str, BackboneSize] = {
    "160 wide, 2 layers": SHIPPED,
    "160 wide, 4 layers": replace(SHIPPED, depth=4),
    "160 wide, 6 layers": replace(SHIPPED, depth=6),
    "224 wide, 4 layers": replace(SHIPPED, width=224, depth=4),
}
"""What is compared. A narrower token could not hold the inputs of two time-bins, 148 numbers,
apart, and so would not begin from the stem's alignment, as these do."""

TIMED_CLIPS = 60


@dataclass(frozen=True)
class BackboneBudget:
    """How much is simulated and trained.

    Args:
        clips: Simulated clips to learn from.
        test_clips: Clips of everyday objects to be judged on.
        steps: Of every backbone.
        batch: Clips per step.
    """

    clips: int = 8_000
    test_clips: int = 500
    steps: int = 600
    batch: int = DEFAULT.pretraining_batch


def compare_backbones(
    *,
    folder: Path,
    budget: BackboneBudget,
    seed: int,
    workers: int,
    backbones: dict[str, BackboneSize] | None = None,
    command: str = "",
) -> RunRecord:
    """Pretrain and judge a backbone of every size.

    Args:
        folder: Keeps clips and checkpoints: a stopped run continues there. `compare_sizes` may have
            left its clips in it.
        budget: How much is simulated and trained.
        seed: Root of clips and weights.
        workers: Processes that simulate.
        backbones: What is compared; None for `BACKBONES`.
        command: The command line, for the record.

    Raises:
        UsageError: If the folder holds clips of another seed or series.
    """
    started, backbones = time.perf_counter(), BACKBONES if backbones is None else backbones
    learned, asked = simulated_sets(folder, budget.clips, budget.test_clips, seed, workers)
    about = f"backbones_{PRETRAINING_VERSION}_{budget.clips}_{budget.steps}_{budget.batch}"
    rows = []
    for name, size in backbones.items():
        place = folder / about / f"{size.width}_{size.depth}_{size.heads}"
        place.mkdir(parents=True, exist_ok=True)
        preset = _preset(size, budget)
        backbone, heads = pretrain(learned, preset=preset, seed=seed, device="cpu", folder=place)
        rows.append(
            {
                "name": name,
                "is_shipped_size": size == SHIPPED,
                "parameters": sum(one.numel() for one in backbone.vit.parameters()),
            }
            | judge(backbone, heads, asked)
            | _times(backbone, asked)
        )
    return RunRecord(
        name="backbones",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers={"rows": rows},
        config={
            "clips": len(learned),
            "test_clips": len(asked),
            "steps": budget.steps,
            "batch": budget.batch,
        },
    )


def _preset(size: BackboneSize, budget: BackboneBudget) -> TrainingPreset:
    return replace(
        DEFAULT,
        backbone_width=size.width,
        backbone_depth=size.depth,
        backbone_heads=size.heads,
        pretraining_draws=budget.steps * budget.batch,
        pretraining_batch=budget.batch,
    )


@torch.inference_mode()
def judge(backbone: FrozenBackbone, heads: DenseHeads, examples: Examples) -> dict[str, float]:
    """Return what the read-outs of a backbone's tokens are worth.

    Returns:
        `kind`: share of readable clips whose kind of motion is told; `missed`: median share of the
        displacement in contact that is missed; `amount`: share of turns and slides whose degrees or
        millimetres are told within the tolerance of an answer.
    """
    kinds: list[bool] = []
    missed: list[float] = []
    amounts: list[bool] = []
    for start in range(0, len(examples), ENCODE_BATCH):
        rows = np.arange(start, min(start + ENCODE_BATCH, len(examples)))
        inputs, truth = dense_batch(examples, rows, "cpu")
        tokens = backbone.encode_inputs(inputs)
        is_seen = truth.kind != UNSEEN
        kinds += (heads.kind(tokens.global_token).argmax(dim=-1) == truth.kind)[is_seen].tolist()
        missed += _missed(heads.patch(tokens.patches)[..., :2] * FLOW_SCALE_PX, truth)
        told = amounts_told(heads.amount(tokens.global_token))
        for column, unit in enumerate(("deg", "mm")):
            pairs = zip(told[:, column].tolist(), truth.amount[:, column].tolist(), strict=True)
            amounts += [within_tolerance(said, true, unit) for said, true in pairs if true == true]
    return {
        "kind": float(np.mean(kinds)),
        "missed": float(np.median(missed)),
        "amount": float(np.mean(amounts)),
    }


def _missed(told_px: Tensor, truth: DenseTruth) -> list[float]:
    """Return the error over the displacement, both RMS in contact, of each clip that moves."""
    weight = truth.contact[..., None] * truth.counts_motion[:, None, None, None, None]
    places = (1, 2, 3, 4)
    error = ((told_px - truth.displacement).square() * weight).sum(dim=places)
    motion = (truth.displacement.square() * weight).sum(dim=places)
    moves = motion > 0
    return (error[moves] / motion[moves]).sqrt().tolist()


def _times(backbone: FrozenBackbone, examples: Examples) -> dict[str, float]:
    """Return milliseconds of encoding a clip that the stem has looked at, on one thread."""
    times = []
    with one_thread():
        for one in examples.inputs[:TIMED_CLIPS]:
            inputs = torch.from_numpy(one[None])
            started = time.perf_counter()
            backbone.encode_inputs(inputs)
            times.append(1e3 * (time.perf_counter() - started))
    return {"ms_median": float(np.median(times)), "ms_p95": float(np.quantile(times, 0.95))}
