"""A language training run's state on disk: weights, optimiser, step and what they belong to."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch

from geotlm_lm.core.errors import UsageError
from geotlm_lm.training.checkpoint import load_checkpoint, save_checkpoint

NAME = "language_checkpoint.pt"

DRAWS = {"draws": 3}
"""Version of how clips and questions are drawn: no run goes on with other draws."""


def store_language(
    folder: Path,
    config: Any,
    model: torch.nn.Module,
    optimiser: torch.optim.Optimizer,
    step: int,
) -> None:
    """Write the state after `step` steps, atomically."""
    state = {
        "config": asdict(config) | DRAWS,
        "step": step,
        "model": model.state_dict(),
        "optimiser": optimiser.state_dict(),
    }
    save_checkpoint(folder / NAME, state)


def restore_language(
    folder: Path, config: Any, model: torch.nn.Module, optimiser: torch.optim.Optimizer
) -> int:
    """Restore the state in `folder` and return its step; 0 when there is none.

    Raises:
        UsageError: If it belongs to another configuration or other tokens, or cannot be read.
    """
    path = folder / NAME
    state = load_checkpoint(path)
    if state is None:
        return 0
    found = state.get("config", {})
    asked = asdict(config) | DRAWS
    differing = sorted(name for name, value in asked.items() if found.get(name) != value)
    if not differing and not torch.equal(
        state["model"]["model.projector.mean"], model.projector.mean.cpu()
    ):
        differing = ["fused_tokens"]
    if differing:
        raise UsageError(
            f"{path}: was trained with another setting of {differing}; delete it to start over, or "
            f"train into another folder."
        )
    model.load_state_dict(state["model"])
    optimiser.load_state_dict(state["optimiser"])
    return int(state["step"])
