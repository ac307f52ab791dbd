"""A language training run's state on disk: weights, optimiser, step and configuration."""

from __future__ import annotations

import os
import pickle
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch

from geotlm_lm.core.errors import UsageError

NAME = "language_checkpoint.pt"


def save_checkpoint(
    folder: Path,
    config: Any,
    model: torch.nn.Module,
    optimiser: torch.optim.Optimizer,
    step: int,
) -> None:
    """Write the state after `step` steps, atomically."""
    folder.mkdir(parents=True, exist_ok=True)
    temporary = folder / f".{NAME}.partial"
    state = {
        "config": asdict(config),
        "step": step,
        "model": model.state_dict(),
        "optimiser": optimiser.state_dict(),
    }
    torch.save(state, temporary)
    os.replace(temporary, folder / NAME)


def load_checkpoint(
    folder: Path, config: Any, model: torch.nn.Module, optimiser: torch.optim.Optimizer
) -> int:
    """Restore the state in `folder` and return its step; 0 when there is none.

    Raises:
        UsageError: If it belongs to another configuration or other tokens, or cannot be read.
    """
    path = folder / NAME
    if not path.exists():
        return 0
    try:
        state = torch.load(path, weights_only=True)
        differing = sorted(k for k, v in asdict(config).items() if state["config"].get(k) != v)
        if not differing and not torch.equal(
            state["model"]["model.projector.mean"], model.projector.mean
        ):
            differing = ["fused_tokens"]
    except (KeyError, EOFError, RuntimeError, pickle.UnpicklingError) as error:
        raise UsageError(
            f"{path}: is not a checkpoint of this training ({type(error).__name__}); delete it to "
            f"start over."
        ) from error
    if differing:
        raise UsageError(
            f"{path}: was trained with another setting of {differing}; delete it to start over, or "
            f"train into another folder."
        )
    model.load_state_dict(state["model"])
    optimiser.load_state_dict(state["optimiser"])
    return int(state["step"])
