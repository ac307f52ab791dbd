"""Train the odometer: from an imprint's movement to the amount it turned or slid."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.core.labels import ROTATIONS
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.data.question_contents import amount_of
from geotlm_lm.odometry.odometer import AMOUNTS, UNITS, Odometer, amounts, place_of
from geotlm_lm.training.scoring import ClipSet

EPOCHS = 30
BATCH = 128
PEAK_RATE = 3e-3
WEIGHT_DECAY = 0.01

SOFT = 0.7
"""Deviation of the target around the true amount, in cells: which of two cells it fell into is
chance."""


def train_odometer(clips: ClipSet, *, seed: int, progress: Progress = silent) -> Odometer:
    """Return an odometer trained on the readable turns and slides of `clips`.

    It takes a quarter of a minute for 40,000 clips and keeps no checkpoint.

    Args:
        clips: With labels that know the size of a pixel.
        seed: Of weights and order.
        progress: Told how far it is.

    Raises:
        ValueError: If none of them turns, or none slides, by a known amount.
    """
    rows, unit, amount = _measured(clips)
    if len(unit.unique()) < len(UNITS):
        raise ValueError("no clip turns, or none slides, by a known amount")
    movement, target = clips.movement[rows], _target(unit, amount)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        odometer = Odometer().train()
        odometer.mean.copy_(movement.mean(dim=0))
        odometer.scale.copy_(movement.std(dim=0, correction=0).clamp(min=1e-3))
        optimiser = torch.optim.AdamW(odometer.parameters(), weight_decay=WEIGHT_DECAY)
        steps = EPOCHS * -(-len(rows) // BATCH)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, PEAK_RATE, total_steps=steps)
        for epoch in range(EPOCHS):
            for chosen in torch.randperm(len(rows)).split(BATCH):
                logits = odometer(movement[chosen])[torch.arange(len(chosen)), unit[chosen]]
                loss = -(target[chosen] * logits.log_softmax(dim=-1)).sum(dim=-1).mean()
                optimiser.zero_grad()
                loss.backward()
                optimiser.step()
                schedule.step()
            progress("train odometer", epoch + 1, EPOCHS)
    return odometer.eval().requires_grad_(False)


def within_tolerance_share(odometer: Odometer, clips: ClipSet) -> dict[str, float | None]:
    """Return how often the middle of the probabilities is within tolerance, by unit.

    None where no readable clip of `clips` has such an amount.
    """
    rows, unit, true = _measured(clips)
    shares: dict[str, float | None] = {}
    for place, name in enumerate(UNITS):
        own = torch.nonzero(unit == place).flatten()
        if not len(own):
            shares[name] = None
            continue
        weights = odometer.read(clips.movement[rows][own], name)
        middle = (weights.cumsum(dim=-1) < 0.5).sum(dim=-1).clamp(max=AMOUNTS - 1)
        said = amounts(name)[middle].tolist()
        right = [
            within_tolerance(a, b, name) for a, b in zip(said, true[own].tolist(), strict=True)
        ]
        shares[name] = float(np.mean(right))
    return shares


def _measured(clips: ClipSet) -> tuple[list[int], Tensor, Tensor]:
    """Return the rows with a known amount, the place of its unit, and the amount, (n,) each."""
    known = [(row, amount_of(clips.labels[row])) for row in clips.readable()]
    known = [(row, amount) for row, amount in known if amount]
    rows = [row for row, _ in known]
    unit = torch.tensor([0 if clips.labels[row].motion in ROTATIONS else 1 for row in rows])
    return rows, unit, torch.tensor([amount for _, amount in known])


def _target(unit: Tensor, amount: Tensor) -> Tensor:
    """Return the wanted probabilities, (n, AMOUNTS): a bell around each true amount."""
    places = torch.stack([place_of(amount, name) for name in UNITS])
    place = places[unit, torch.arange(len(unit))].clamp(0, AMOUNTS - 1)
    off = torch.arange(AMOUNTS) - place[:, None]
    return torch.softmax(-(off.square()) / (2 * SOFT**2), dim=-1)
