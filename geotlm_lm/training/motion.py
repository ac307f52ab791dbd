"""Train the network that fuses what is measured into a Belief."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.process import Progress, silent
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

    def to(self, device: str) -> Truths:
        """Return them on a device."""
        return Truths(*(value.to(device) for value in vars(self).values()))


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
    device: str = "cpu",
    progress: Progress = silent,
) -> MotionNetwork:
    """Return a network trained on what is measured of labelled clips.

    It takes two minutes for 48,000 clips and keeps no checkpoint.

    Args:
        measured: Of n clips.
        labels: The truth of each.
        seed: Of weights and order.
        device: Where to train.
        progress: Told how far it is.
    """
    truths, measured = Truths.of(labels).to(device), measured.to(device)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = MotionNetwork(measured.hints.shape[1]).to(device).train()
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
    return network.cpu().eval().requires_grad_(False)


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


SPAN_DEVIATIONS = 1.645
"""Half of a span of nine in ten, in deviations."""


@dataclass(frozen=True)
class AmountTold:
    """How far a component that counts and can be read is told to go, and how far it went.

    Args:
        row: Of the clip.
        component: Which.
        said: Degrees, pixels or mm, not negative.
        true: Likewise.
        deviation: Of what is said.
        is_way_right: Whether its way is told rightly.
    """

    row: int
    component: Component
    said: float
    true: float
    deviation: float
    is_way_right: bool

    @property
    def is_right(self) -> bool:
        """Whether the amount is within tolerance."""
        unit = {Component.TURN: "deg", Component.SLIDE: "px", Component.PRESS: "mm"}
        return within_tolerance(self.said, self.true, unit[self.component])

    @property
    def deviations_off(self) -> float:
        """How far off the amount is, in deviations."""
        return abs(self.said - self.true) / self.deviation


def amounts_told(told: Beliefs, truths: Sequence[ClipTruth]) -> Iterator[AmountTold]:
    """Yield the readable components that count."""
    degrees = (told.path[:, 0] / told.radius_px).rad2deg()
    for row, truth in enumerate(truths):
        true = truth.twist
        for component in COMPONENTS:
            if not (truth.counts[component] and truth.is_readable[component]):
                continue
            if component is Component.TURN:
                said = float(degrees[row])
                off = float((told.deviation[row, 0] / told.radius_px[row]).rad2deg())
                found = abs(said), abs(true.turn_deg), off, (said > 0) == (true.turn_deg > 0)
            elif component is Component.SLIDE:
                x, y = told.path[row, 1:].tolist()
                along = (x * true.right_px + y * true.down_px) / max(np.hypot(x, y), 1e-9)
                off = float(told.deviation[row, 1:3].square().mean().sqrt())
                is_right = along >= true.slide_px * 0.5**0.5
                found = float(np.hypot(x, y)), true.slide_px, off, bool(is_right)
            else:
                said, off = float(told.inward_mm[row]), float(told.deviation[row, 3])
                is_right = (float(told.press_in[row]) > 0) == (true.inward_mm > 0)
                found = abs(said), abs(true.inward_mm), off, is_right
            yield AmountTold(row, component, *found)


@torch.inference_mode()
def widen_spans(network: MotionNetwork, measured: Measured, labels: Sequence[MotionLabel]) -> None:
    """Let the network's spans of nine in ten hold as many.

    Args:
        network: Trained.
        measured: Of clips of objects that it has not seen.
        labels: Their truth.
    """
    truths = [component_truth(label) for label in labels]
    found = list(amounts_told(network(measured), truths))
    for places, component in zip(((0,), (1, 2), (3,)), COMPONENTS, strict=True):
        off = [one.deviations_off for one in found if one.component is component]
        if len(off) >= FEWEST_WIDENED:
            network.widening[list(places)] *= float(np.quantile(off, 0.9)) / SPAN_DEVIATIONS


FEWEST_WIDENED = 30
"""Amounts below which a tenth of them is chance."""


@torch.inference_mode()
def motion_scores(told: Beliefs, labels: Sequence[MotionLabel]) -> dict[str, float]:
    """Return how what is believed fares on the readable components that are not ambiguous.

    Shares: of senses of turns and ways of slides that are right, of components told rightly to
    count or not, of clips that turn and slide of which both are right, of amounts within
    `core.tolerance`, and of spans of nine in ten that hold the true one.
    """
    truths = [component_truth(label) for label in labels]
    hits: dict[str, list[bool]] = {}
    for row, truth in enumerate(truths):
        for place, component in enumerate(COMPONENTS):
            wanted = truth.counts[component]
            if wanted is not None and (truth.is_touched or component is Component.TURN):
                is_right = bool(told.counts[row, place] > 0) == wanted
                hits.setdefault(f"{component} counts", []).append(is_right)
    ways: dict[int, dict[Component, bool]] = {}
    for one in amounts_told(told, truths):
        ways.setdefault(one.row, {})[one.component] = one.is_way_right
        for name, is_so in (
            ("way", one.is_way_right),
            ("amount", one.is_right),
            ("span", one.deviations_off <= SPAN_DEVIATIONS),
        ):
            hits.setdefault(f"{one.component} {name}", []).append(is_so)
    both = (Component.TURN, Component.SLIDE)
    hits["both ways"] = [
        found[both[0]] and found[both[1]] for found in ways.values() if set(both) <= set(found)
    ]
    hits = {name: values for name, values in hits.items() if values}
    return {name: float(np.mean(values)) for name, values in sorted(hits.items())} | {
        f"{name}, number": len(values) for name, values in sorted(hits.items())
    }
