"""Pretrain the embedded backbone on the simulator's dense truth, then freeze it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from geotlm_lm.backbone.frozen import FrozenBackbone
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.vit import ViT, ViTConfig
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
    device: str,
    folder: Path,
    first: int = 0,
    progress: Progress = silent,
) -> tuple[FrozenBackbone, DenseHeads]:
    """Train the backbone from random weights; resumes from `folder` where a run was interrupted.

    Args:
        examples: Simulated training examples.
        preset: Sizes and lengths.
        seed: Root seed.
        device: Torch device.
        folder: Where the checkpoint lies.
        first: The examples before this one are left for others to learn from.
        progress: Told how far it is.

    Returns:
        The backbone, and the linear read-outs it was trained through.
    """
    steps = max(preset.pretraining_draws // preset.pretraining_batch, 1)
    learner = _Learner(preset, steps, seed, device)
    path = folder / "backbone.pt"
    done = learner.restore(path)
    saved_at = time.monotonic()
    try:
        while done < steps:
            rng = generator_for(seed, "pretraining", done)
            rows = np.sort(rng.integers(first, len(examples), size=preset.pretraining_batch))
            batch = mirrored_at_random(*dense_batch(examples, rows, device), rng)
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

    def __init__(self, preset: TrainingPreset, steps: int, seed: int, device: str) -> None:
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
        self.vit.to(device)
        self.heads.to(device)
        self._parameters = [*self.vit.parameters(), *self.heads.parameters()]
        self._optimiser = torch.optim.AdamW(self._parameters, PEAK_RATE, weight_decay=WEIGHT_DECAY)
        self._schedule = torch.optim.lr_scheduler.LambdaLR(
            self._optimiser, lambda step: _rate(step, steps)
        )
        self._device = device.split(":")[0]

    def step(self, inputs: Tensor, truth: DenseTruth) -> float:
        """Take one step and return its loss."""
        with torch.autocast(self._device, torch.bfloat16, enabled=has_bfloat16(self._device)):
            tokens = self.vit(inputs)
        loss = dense_loss(
            Tokens(tokens.global_token.float(), tokens.patches.float()), self.heads, truth
        )
        self._optimiser.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self._parameters, 1.0)
        self._optimiser.step()
        self._schedule.step()
        return loss.item()

    def store(self, path: Path, done: int) -> None:
        """Write everything the next step depends on."""
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


def has_bfloat16(device: str) -> bool:
    """Tell whether bfloat16 products are fast: 2.7 times float32 on a processor that has them."""
    return device == "cuda" or torch.ops.mkldnn._is_mkldnn_bf16_supported()


def _rate(step: int, steps: int) -> float:
    """Warm up linearly, then fall along a half cosine to zero."""
    warmup = max(WARMUP_SHARE * steps, 1.0)
    if step < warmup:
        return (step + 1) / (warmup + 1)
    return 0.5 * (1 + float(np.cos(np.pi * (step - warmup) / max(steps - warmup, 1))))
