"""Train the network that fuses what is measured into a Belief."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.motion.measured import Measured
from geotlm_lm.motion.network import Beliefs, MotionNetwork
from geotlm_lm.training.component_truth import ClipTruth, component_truth

EPOCHS = 24
BATCH = 256
PEAK_RATE = 2e-3
WEIGHT_DECAY = 0.02


@dataclass(frozen=True, eq=False)
class Truths:
    """What is true of n clips, NaN where nothing is asked.

    Args:
        turn_rad: Turn, clockwise positive, (n,).
        slide_px: Travel to the right and down, (n, 2).
        inward_mm: Approach, (n,).
        counts: Whether turn, slide and press count, (n, 3).
        readable: Whether they can be read, (n, 3).
        contact: Whether anything touches, (n,).
    """

    turn_rad: Tensor
    slide_px: Tensor
    inward_mm: Tensor
    counts: Tensor
    readable: Tensor
    contact: Tensor

    @classmethod
    def of(cls, labels: Sequence[MotionLabel]) -> Truths:
        """Lay out what labels tell."""
        truths = [component_truth(label) for label in labels]
        asked = np.array([_asked(one) for one in truths], np.float32)
        twists = [one.twist for one in truths]
        turn = np.radians([one.turn_deg for one in twists]).astype(np.float32) * asked[:, 0]
        slide = np.array([(one.right_px, one.down_px) for one in twists], np.float32)
        inward = np.array([one.inward_mm for one in twists], np.float32) * asked[:, 2]
        counts = [[_number(one.counts[component]) for component in COMPONENTS] for one in truths]
        readable = [[_readable(one, component) for component in COMPONENTS] for one in truths]
        return cls(
            torch.from_numpy(turn),
            torch.from_numpy(slide * asked[:, 1:2]),
            torch.from_numpy(inward),
            torch.tensor(counts),
            torch.tensor(readable),
            torch.tensor([float(one.is_touched) for one in truths]),
        )

    def only(self, rows: Tensor) -> Truths:
        """Return those of some clips."""
        return Truths(*(value[rows] for value in vars(self).values()))


def _asked(truth: ClipTruth) -> list[float]:
    """Return 1 where an amount is asked for, NaN elsewhere."""
    is_asked = [
        truth.is_touched and (truth.is_readable[one] or truth.counts[one] is False)
        for one in COMPONENTS
    ]
    return [1.0 if one else float("nan") for one in is_asked]


def _number(is_so: bool | None) -> float:
    return float("nan") if is_so is None else float(is_so)


def _readable(truth: ClipTruth, component: Component) -> float:
    """Return whether a component that moves enough to be asked after can be read."""
    if not truth.is_touched or truth.counts[component] is False:
        return float("nan")
    return float(truth.is_readable[component])


def train_motion(
    measured: Measured,
    labels: Sequence[MotionLabel],
    *,
    seed: int,
    progress: Progress = silent,
) -> MotionNetwork:
    """Return a network trained on what is measured of labelled clips.

    It takes two minutes for 48,000 clips and keeps no checkpoint.

    Args:
        measured: Of n clips.
        labels: The truth of each.
        seed: Of weights and order.
        progress: Told how far it is.
    """
    truths = Truths.of(labels)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = MotionNetwork(measured.hints.shape[1]).train()
        network.start_at_measured()
        network.mean.copy_(measured.hints.mean(dim=0))
        network.scale.copy_(measured.hints.std(dim=0, correction=0).clamp(min=1e-3))
        optimiser = torch.optim.AdamW(network.parameters(), weight_decay=WEIGHT_DECAY)
        steps = EPOCHS * -(-len(labels) // BATCH)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, PEAK_RATE, total_steps=steps)
        for epoch in range(EPOCHS):
            for rows in torch.randperm(len(labels)).split(BATCH):
                loss = motion_network_loss(network(measured.only(rows)), truths.only(rows))
                optimiser.zero_grad()
                loss.backward()
                torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
                optimiser.step()
                schedule.step()
            progress("train motion", epoch + 1, EPOCHS)
    return network.eval().requires_grad_(False)


def motion_network_loss(told: Beliefs, true: Truths) -> Tensor:
    """Return the mean negative log-likelihood of what is asked, a Laplace density of each path."""
    path = torch.cat([(true.turn_rad * told.radius_px)[:, None], true.slide_px], dim=1)
    wanted = torch.cat([path, true.inward_mm[:, None]], dim=1)
    said = torch.cat([told.path, told.inward_mm[:, None]], dim=1)
    # A Laplace density's scale is its deviation over the root of two.
    scale = told.deviation / 2**0.5
    errors = (said - wanted.nan_to_num()).abs() / scale + scale.log()
    spread = _mean(errors, ~wanted.isnan())
    counted = _cross_entropy(told.counts, true.counts)
    readable = _cross_entropy(told.readable, true.readable)
    contact = _cross_entropy(told.contact, true.contact)
    presses = (true.counts[:, 2] == 1) & ~true.inward_mm.isnan()
    inward = _cross_entropy(told.press_in, _where(presses, true.inward_mm > 0))
    turns = (true.counts[:, 0] == 1) & ~true.turn_rad.isnan()
    sense = _cross_entropy(told.sense(), _where(turns, true.turn_rad > 0))
    slides = (true.counts[:, 1] == 1) & ~true.slide_px[:, 0].isnan()
    x, y = true.slide_px.nan_to_num().unbind(dim=1)
    quarter = torch.remainder((torch.atan2(y, x) / (torch.pi / 2)).round().long(), 4)
    ways = _mean(F.nll_loss(told.quarters().log(), quarter, reduction="none"), slides)
    return spread + 2 * counted + 0.5 * readable + contact + inward + sense + 0.5 * ways


def _where(is_asked: Tensor, is_so: Tensor) -> Tensor:
    return torch.where(is_asked, is_so.float(), torch.nan)


def _cross_entropy(logits: Tensor, wanted: Tensor) -> Tensor:
    """Return the mean cross entropy where something is wanted, which is no NaN."""
    losses = F.binary_cross_entropy_with_logits(logits, wanted.nan_to_num(), reduction="none")
    return _mean(losses, ~wanted.isnan())


def _mean(losses: Tensor, is_asked: Tensor) -> Tensor:
    """Return the mean of what is asked; 0 where nothing is."""
    return (losses * is_asked).sum() / is_asked.sum().clamp(min=1)


@torch.inference_mode()
def motion_scores(told: Beliefs, labels: Sequence[MotionLabel]) -> dict[str, float]:
    """Return how what is believed fares on the readable components that are not ambiguous.

    Shares: of senses of turns and ways of slides that are right, of components told rightly to
    count or not, of clips that turn and slide of which both are right, of amounts within
    `core.tolerance`, and of spans of nine in ten that hold the true one.
    """
    truths = [component_truth(label) for label in labels]
    degrees = (told.path[:, 0] / told.radius_px).rad2deg().tolist()
    hits: dict[str, list[bool]] = {}

    def add(name: str, is_right: bool) -> None:
        hits.setdefault(name, []).append(bool(is_right))

    for row, truth in enumerate(truths):
        twist, right = truth.twist, {}
        for place, component in enumerate(COMPONENTS):
            wanted = truth.counts[component]
            if wanted is not None and (truth.is_touched or component is Component.TURN):
                add(f"{component} counts", (told.counts[row, place] > 0) == wanted)
            if not (wanted and truth.is_readable[component]):
                continue
            if component is Component.TURN:
                right[component] = (degrees[row] > 0) == (twist.turn_deg > 0)
                said, true, unit = abs(degrees[row]), abs(twist.turn_deg), "deg"
                spread = told.deviation[row, 0] / told.radius_px[row]
                spread = float(spread.rad2deg())
            elif component is Component.SLIDE:
                x, y = told.path[row, 1:].tolist()
                along = (x * twist.right_px + y * twist.down_px) / max(np.hypot(x, y), 1e-9)
                right[component] = along >= twist.slide_px * 0.5**0.5
                said, true, unit = float(np.hypot(x, y)), twist.slide_px, "px"
                spread = float(told.deviation[row, 1:3].square().mean().sqrt())
            else:
                inward = float(told.inward_mm[row])
                right[component] = (float(told.press_in[row]) > 0) == (twist.inward_mm > 0)
                said, true, unit = abs(inward), abs(twist.inward_mm), "mm"
                spread = float(told.deviation[row, 3])
            add(f"{component} way", right[component])
            add(f"{component} amount", within_tolerance(said, true, unit))
            add(f"{component} span", abs(said - true) <= 1.645 * spread)
        if Component.TURN in right and Component.SLIDE in right:
            add("both ways", right[Component.TURN] and right[Component.SLIDE])
    return {name: float(np.mean(values)) for name, values in sorted(hits.items())} | {
        f"{name}, number": len(values) for name, values in sorted(hits.items())
    }
