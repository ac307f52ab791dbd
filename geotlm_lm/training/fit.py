"""One training loop and one checkpoint: continue, learn, store, keep the best epoch.

A step is a function of its number alone and of the parts that are stored, so that an interrupted
run ends in the same weights as one without a break.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import replacing
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.training.ranks import ALONE, Ranks

CHECKPOINT_EVERY_S = 30.0


def save_checkpoint(path: Path, state: dict[str, Any]) -> None:
    """Write `state` (tensors and plain values) so that a kill leaves the old file or the new."""
    with replacing(path) as stream:
        torch.save(state, stream)


def load_checkpoint(path: Path) -> dict[str, Any] | None:
    """Return the state saved at `path`, or None where there is none.

    Raises:
        UsageError: If the file cannot be read.
    """
    if not path.exists():
        return None
    try:
        return torch.load(path, weights_only=True, map_location="cpu")
    except Exception as error:
        raise UsageError(
            f"{path}: the checkpoint cannot be read ({type(error).__name__}); delete it to start "
            f"this stage again."
        ) from error


def fit(
    step: Callable[[int], str | None],
    steps: int,
    parts: Mapping[str, Any],
    *,
    path: Path | None = None,
    about: Any = None,
    steps_per_report: int = 1,
    ranks: Ranks = ALONE,
    progress: Progress = silent,
) -> None:
    """Take the steps that are left.

    Args:
        step: Takes the step of a number, from 0; returns what to report, or None.
        steps: How many there are.
        parts: What the next step depends on, each with `state_dict` and `load_state_dict`.
        path: Checkpoint, which the first rank writes now and then and at the end, an interrupt's
            as well; None keeps none.
        about: Plain values that decide the training: no checkpoint of others is continued.
        steps_per_report: Steps in what `progress` counts.
        ranks: Which process this is.
        progress: Called after each report.

    Raises:
        UsageError: If the checkpoint is of another training or cannot be read.
    """
    state = None if path is None else load_checkpoint(path)
    done = 0
    if state is not None:
        if state.get("about") != about:
            raise UsageError(
                f"{path}: was trained on the tokens of another backbone, on other clips or with "
                f"other settings; delete it to start over."
            )
        for name, part in parts.items():
            part.load_state_dict(state[name])
        done = int(state["step"])

    def store() -> None:
        if path is not None and ranks.is_first:
            states = {name: part.state_dict() for name, part in parts.items()}
            save_checkpoint(path, states | {"step": done, "about": about})

    stored_at = time.monotonic()
    try:
        while done < steps:
            with uninterrupted_step():
                report = step(done)
                done += 1
            if report is not None:
                progress(report, done // steps_per_report, steps // steps_per_report)
            if time.monotonic() - stored_at > CHECKPOINT_EVERY_S:
                store()
                stored_at = time.monotonic()
    finally:
        store()


def learn(
    loss: Tensor,
    optimiser: torch.optim.Optimizer,
    schedule: torch.optim.lr_scheduler.LRScheduler | None = None,
    *,
    most_norm: float | None = None,
    ranks: Ranks = ALONE,
) -> float:
    """Take one optimiser step down a loss, this rank's share, and return the whole batch's."""
    parameters = [value for group in optimiser.param_groups for value in group["params"]]
    optimiser.zero_grad(set_to_none=True)
    loss.backward()
    whole_loss = ranks.average(parameters, loss.item())
    if most_norm is not None:
        nn.utils.clip_grad_norm_(parameters, most_norm)
    optimiser.step()
    if schedule is not None:
        schedule.step()
    return whole_loss


class Best:
    """The epoch of the highest score, the first among equals, and its weights."""

    def __init__(self, module: nn.Module) -> None:
        self.module = module
        self.epoch, self.score, self.weights = 0, None, None

    def offer(self, epoch: int, score: float | tuple[float, ...]) -> None:
        """Keep the weights of an epoch, counted from 1, if it is the best so far."""
        if self.score is None or score > self.score:
            weights = self.module.state_dict()
            self.weights = {name: value.clone() for name, value in weights.items()}
            self.epoch, self.score = epoch, score

    def state_dict(self) -> dict[str, Any]:
        """Return all of it as torch stores it."""
        return {"epoch": self.epoch, "score": self.score, "weights": self.weights}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take what `state_dict` returned."""
        self.epoch, self.score, self.weights = state["epoch"], state["score"], state["weights"]


def fit_epochs(
    module: nn.Module,
    optimiser: torch.optim.Optimizer,
    loss: Callable[[Tensor], Tensor],
    score: Callable[[], float | tuple[float, ...]],
    *,
    count: int,
    batch: int,
    epochs: int,
    order: Callable[[int], Any],
    name: str = "",
    path: Path | None = None,
    about: Any = None,
    progress: Progress = silent,
) -> Best:
    """Go over all rows once an epoch, and leave the module with the weights of the best epoch.

    `loss` is that of some rows, `score` the module's after an epoch, `order` that of the rows of an
    epoch, (count,); `path`, `about` and `progress` are as in `fit`.
    """
    steps_per_epoch = -(-count // batch)
    best = Best(module)

    @lru_cache(maxsize=1)
    def batches(epoch: int) -> tuple[Tensor, ...]:
        return torch.as_tensor(order(epoch)).split(batch)

    def step(number: int) -> str | None:
        epoch, place = divmod(number, steps_per_epoch)
        learn(loss(batches(epoch)[place]), optimiser)
        if place + 1 < steps_per_epoch:
            return None
        reached = score()
        best.offer(epoch + 1, reached)
        return f"{name}, validation {reached:.3f}" if isinstance(reached, float) else name

    parts = {"module": module, "optimiser": optimiser, "best": best}
    total = epochs * steps_per_epoch
    shared = {"path": path, "about": about, "progress": progress}
    fit(step, total, parts, steps_per_report=steps_per_epoch, **shared)
    module.load_state_dict(best.weights)
    return best
