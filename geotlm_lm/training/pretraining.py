"""Pretrain the embedded backbone on the simulator's dense truth, then freeze it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.vit import FrozenBackbone, ViT, ViTConfig
from geotlm_lm.core.interrupts import uninterrupted_step
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.seeding import generator_for, seed_for
from geotlm_lm.training.checkpoint import load_checkpoint, save_checkpoint
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.dense_targets import (
    DenseHeads,
    DenseTruth,
    dense_batch,
    dense_loss,
    mirrored_at_random,
)
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.ranks import ALONE, Ranks

PRETRAINING_VERSION = 5
"""Raised when the backbone is shown or asked other things: no older run is continued."""

CHECKPOINT_EVERY_S = 30.0
PEAK_RATE, WEIGHT_DECAY = 1e-3, 0.05
WARMUP_SHARE = 0.05


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

    Args:
        examples: Simulated training examples.
        preset: Sizes and lengths.
        seed: Root seed.
        folder: Where the checkpoint lies.
        first: The examples before this one are left for others to learn from.
        ranks: Which process this is, and where it trains.
        progress: Told how far it is.

    Returns:
        The backbone, and the linear read-outs it was trained through.
    """
    ranks.refuse_uneven(preset.pretraining_batch)
    steps = max(preset.pretraining_draws // preset.pretraining_batch, 1)
    learner = _Learner(preset, steps, seed, ranks)
    path = folder / "backbone.pt"
    done = learner.restore(path)
    saved_at = time.monotonic()
    try:
        while done < steps:
            rng = generator_for(seed, "pretraining", done)
            rows = np.sort(rng.integers(first, len(examples), size=preset.pretraining_batch))
            mine = dense_batch(examples, ranks.share(rows), ranks.device)
            batch = mirrored_at_random(*mine, rng, ranks)
            with uninterrupted_step():
                loss = learner.step(*batch)
                done += 1
            progress(f"pretrain backbone, loss {loss:.3f}", done, steps)
            if time.monotonic() - saved_at > CHECKPOINT_EVERY_S:
                learner.store(path, done)
                saved_at = time.monotonic()
    finally:
        learner.store(path, done)
    return FrozenBackbone(learner.vit), learner.heads.cpu().requires_grad_(False)


class _Learner:
    """Weights, optimiser and schedule of one pretraining run."""

    def __init__(self, preset: TrainingPreset, steps: int, seed: int, ranks: Ranks) -> None:
        config = ViTConfig(
            PATCH_INPUT_DIM, preset.backbone_width, preset.backbone_depth, preset.backbone_heads
        )
        generator = torch.Generator().manual_seed(seed_for(seed, "weights", "backbone"))
        self.vit = ViT(config).initialise(generator)
        self.heads = DenseHeads(config.width)
        for head in (self.heads.summary, self.heads.components, self.heads.amount):
            nn.init.normal_(head.weight, 0, config.width**-0.5, generator=generator)
            nn.init.zeros_(head.bias)
        self.heads.start_from_alignment(self.vit.embed_one_bin())
        self.vit.to(ranks.device)
        self.heads.to(ranks.device)
        self._parameters = [*self.vit.parameters(), *self.heads.parameters()]
        self._optimiser = torch.optim.AdamW(self._parameters, PEAK_RATE, weight_decay=WEIGHT_DECAY)
        self._schedule = torch.optim.lr_scheduler.LambdaLR(
            self._optimiser, lambda step: _rate(step, steps)
        )
        self._ranks = ranks

    def step(self, inputs: Tensor, truth: DenseTruth) -> float:
        """Take one step with this rank's share of a batch and return the whole batch's loss."""
        with self._ranks.bfloat16_products():
            tokens = self.vit(inputs)
        tokens = Tokens(tokens.global_token.float(), tokens.patches.float())
        loss = dense_loss(tokens, self.heads, truth, self._ranks)
        self._optimiser.zero_grad(set_to_none=True)
        loss.backward()
        told = self._ranks.average(self._parameters, loss.item())
        nn.utils.clip_grad_norm_(self._parameters, 1.0)
        self._optimiser.step()
        self._schedule.step()
        return told

    def store(self, path: Path, done: int) -> None:
        """Write everything the next step depends on; the first rank does."""
        if not self._ranks.is_first:
            return
        state = {name: part.state_dict() for name, part in self._parts().items()}
        save_checkpoint(path, state | {"step": done})

    def restore(self, path: Path) -> int:
        """Read what `store` wrote; return the number of steps already taken."""
        state = load_checkpoint(path)
        if state is None:
            return 0
        for name, part in self._parts().items():
            part.load_state_dict(state[name])
        return int(state["step"])

    def _parts(self) -> dict[str, Any]:
        return {
            "vit": self.vit,
            "heads": self.heads,
            "optimiser": self._optimiser,
            "schedule": self._schedule,
        }


def _rate(step: int, steps: int) -> float:
    """Warm up linearly, then fall along a half cosine to zero."""
    warmup = max(WARMUP_SHARE * steps, 1.0)
    if step < warmup:
        return (step + 1) / (warmup + 1)
    return 0.5 * (1 + float(np.cos(np.pi * (step - warmup) / max(steps - warmup, 1))))
