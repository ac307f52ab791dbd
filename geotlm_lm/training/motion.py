"""Train the network that fuses what is measured into a Belief."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.core.twist import BARELY_MM, BARELY_PX, COMPONENTS, Component
from geotlm_lm.motion.belief import SPAN_DEVIATIONS
from geotlm_lm.motion.measured import Measured
from geotlm_lm.motion.network import RELIEF_CHAINED, Beliefs, MotionNetwork
from geotlm_lm.training.fit import fit, learn
from geotlm_lm.training.truth import ClipTruth, component_truth

EPOCHS = 32
BATCH = 256
PEAK_RATE = 2e-3
WEIGHT_DECAY = 0.02


@dataclass(frozen=True, eq=False)
class Truths:
    """What is true of n clips, NaN where nothing is asked."""

    turn_rad: Tensor  # (n,), clockwise positive
    slide_px: Tensor  # (n, 2), to the right and down
    inward_mm: Tensor  # (n,)
    moves: Tensor  # (n, 3), whether turn, slide and press move
    readable: Tensor  # (n, 3), whether they can be read
    contact: Tensor  # (n,), whether anything touches

    @classmethod
    def of(cls, labels: Sequence[MotionLabel]) -> Truths:
        """Lay out what labels tell."""
        truths = [component_truth(label) for label in labels]
        twists = [truth.twist for truth in truths]

        def each(value: Callable[[ClipTruth, Component], bool | None]) -> Tensor:
            rows = [[value(truth, part) for part in COMPONENTS] for truth in truths]
            return torch.tensor(
                [[math.nan if x is None else float(x) for x in row] for row in rows]
            )

        def amount(truth: ClipTruth, part: Component) -> bool | None:
            """Tell that an amount is asked: where it can be read or is known not to move."""
            is_known = truth.is_readable[part] or truth.moves[part] is False
            return True if truth.is_touched and is_known else None

        def readable(truth: ClipTruth, part: Component) -> bool | None:
            """Tell whether what moves enough to be asked after can be read."""
            moves = truth.is_touched and truth.moves[part] is not False
            return truth.is_readable[part] if moves else None

        asked = each(amount)
        turn = np.radians([twist.turn_deg for twist in twists]).astype(np.float32)
        slide = np.array([(twist.right_px, twist.down_px) for twist in twists], np.float32)
        inward = np.array([twist.inward_mm for twist in twists], np.float32)
        return cls(
            torch.from_numpy(turn) * asked[:, 0],
            torch.from_numpy(slide) * asked[:, 1:2],
            torch.from_numpy(inward) * asked[:, 2],
            each(lambda truth, part: truth.moves[part]),
            each(readable),
            torch.tensor([float(truth.is_touched) for truth in truths]),
        )

    def only(self, rows: Tensor) -> Truths:
        """Return those of some clips."""
        return Truths(*(value[rows] for value in vars(self).values()))

    def to(self, device: str) -> Truths:
        """Return them on a device."""
        return Truths(*(value.to(device) for value in vars(self).values()))


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
    """
    truths, measured = Truths.of(labels).to(device), measured.to(device)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = MotionNetwork(measured.hints.shape[1]).to(device).train()
        network.see(measured.hints)
        optimiser = torch.optim.AdamW(network.parameters(), weight_decay=WEIGHT_DECAY)
        per_epoch = -(-len(labels) // BATCH)
        steps = EPOCHS * per_epoch
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, PEAK_RATE, total_steps=steps)
        batches: list[Tensor] = []

        def step(number: int) -> str | None:
            if not batches:
                batches.extend(torch.randperm(len(labels)).split(BATCH))
            rows = batches.pop(0)
            loss = motion_network_loss(network(measured.only(rows)), truths.only(rows))
            learn(loss, optimiser, schedule, most_norm=1.0)
            return None if batches else "train motion"

        fit(step, steps, {}, steps_per_report=per_epoch, progress=progress)
    return network.cpu().eval().requires_grad_(False)


def motion_network_loss(beliefs: Beliefs, true: Truths) -> Tensor:
    """Return the mean negative log-likelihood of what is asked, a Laplace density of each path."""
    path = torch.cat([(true.turn_rad * beliefs.radius_px)[:, None], true.slide_px], dim=1)
    wanted = torch.cat([path, true.inward_mm[:, None]], dim=1)
    stated = torch.cat([beliefs.path, beliefs.inward_mm[:, None]], dim=1)
    # A Laplace density's scale is its deviation over the root of two.
    scale = beliefs.deviation / 2**0.5
    errors = (stated - wanted.nan_to_num()).abs() / scale + scale.log()
    spread = _mean(errors, ~wanted.isnan())
    readable = _cross_entropy(beliefs.readable, true.readable)
    contact = _cross_entropy(beliefs.contact, true.contact)
    turns = (true.moves[:, 0] == 1) & ~true.turn_rad.isnan()
    sense = _cross_entropy(torch.logit(beliefs.sense), _where(turns, true.turn_rad > 0))
    slides = (true.moves[:, 1] == 1) & ~true.slide_px[:, 0].isnan()
    x, y = true.slide_px.nan_to_num().unbind(dim=1)
    quarter = torch.remainder((torch.atan2(y, x) / (torch.pi / 2)).round().long(), 4)
    ways = _mean(F.nll_loss(beliefs.quarters().log(), quarter, reduction="none"), slides)
    return spread + 0.5 * readable + contact + sense + ways


def _where(is_asked: Tensor, is_so: Tensor) -> Tensor:
    return torch.where(is_asked, is_so.float(), torch.nan)


def _cross_entropy(logits: Tensor, wanted: Tensor) -> Tensor:
    """Return the mean cross entropy where something is wanted, which is no NaN."""
    losses = F.binary_cross_entropy_with_logits(logits, wanted.nan_to_num(), reduction="none")
    return _mean(losses, ~wanted.isnan())


def _mean(losses: Tensor, is_asked: Tensor) -> Tensor:
    """Return the mean of what is asked; 0 where nothing is."""
    return (losses * is_asked).sum() / is_asked.sum().clamp(min=1)


FEWEST_WIDENED = 30
"""Amounts below which a tenth of them is chance."""

UNITS = {Component.TURN: "deg", Component.SLIDE: "px", Component.PRESS: "mm"}


class Amount(NamedTuple):
    """How far a readable component that moves is believed to go, and how far it went.

    Amounts are degrees, pixels or mm, not negative, with the deviation of the believed one.
    """

    row: int
    component: Component
    believed: float
    true: float
    deviation: float
    is_way_right: bool

    @property
    def deviations_off(self) -> float:
        """How far off the amount is, in deviations."""
        return abs(self.believed - self.true) / self.deviation


def believed_amounts(beliefs: Beliefs, truths: Sequence[ClipTruth]) -> Iterator[Amount]:
    """Yield the readable components that move."""
    degrees = (beliefs.path[:, 0] / beliefs.radius_px).rad2deg()
    for row, truth in enumerate(truths):
        true, deviation = truth.twist, beliefs.deviation[row]
        for component in COMPONENTS:
            if not (truth.moves[component] and truth.is_readable[component]):
                continue
            if component is Component.TURN:
                turn = float(degrees[row])
                off = float((deviation[0] / beliefs.radius_px[row]).rad2deg())
                amount = abs(turn), abs(true.turn_deg), off, (turn > 0) == (true.turn_deg > 0)
            elif component is Component.SLIDE:
                x, y = beliefs.path[row, 1:].tolist()
                along = (x * true.right_px + y * true.down_px) / max(np.hypot(x, y), 1e-9)
                off = float(deviation[1:3].square().mean().sqrt())
                is_right = bool(along >= true.slide_px * 0.5**0.5)
                amount = float(np.hypot(x, y)), true.slide_px, off, is_right
            else:
                inward = float(beliefs.inward_mm[row])
                is_right = (inward > 0) == (true.inward_mm > 0)
                amount = abs(inward), abs(true.inward_mm), float(deviation[3]), is_right
            yield Amount(row, component, *amount)


FALSE_ALARMS = 0.025
"""Share of objects at rest, such as the network has not seen, that may seem to press: of real held
imprints one in a hundred then does, and of simulated presses of 0.15 mm and more four in five."""


@torch.inference_mode()
def set_significance(
    network: MotionNetwork, measured: Measured, labels: Sequence[MotionLabel]
) -> None:
    """Raise what is significant of a press, which is learned, until so few at rest are."""
    significance, truths = network(measured).significance[:, 2], Truths.of(labels)
    at_rest = (truths.moves[:, 2] == 0) & (truths.contact == 1)
    if int(at_rest.sum()) >= FEWEST_WIDENED:
        reached = torch.quantile(significance[at_rest], 1 - FALSE_ALARMS)
        network.least[2] = torch.maximum(network.least[2], reached)


@torch.inference_mode()
def widen_spans(network: MotionNetwork, measured: Measured, labels: Sequence[MotionLabel]) -> None:
    """Let the spans of nine in ten hold as many, of clips of objects the network has not seen.

    On gels with dots, which lag behind the object, they are wider. What moves barely is left out:
    noise is most of it, and no share of it.
    """
    truths = [component_truth(label) for label in labels]

    def is_barely(amount: Amount) -> bool:
        path = truths[amount.row].twist.path(amount.component, labels[amount.row].radius_px)
        return path < (BARELY_MM if amount.component is Component.PRESS else BARELY_PX)

    amounts = list(believed_amounts(network(measured), truths))
    amounts = [amount for amount in amounts if not is_barely(amount)]
    kinds = (~measured.is_measured[:, RELIEF_CHAINED]).long().tolist()
    for kind, wider in enumerate(network.widening):
        own = [amount for amount in amounts if kinds[amount.row] == kind]
        for places, component in zip(((0,), (1, 2), (3,)), COMPONENTS, strict=True):
            off = [amount.deviations_off for amount in own if amount.component is component]
            if len(off) >= FEWEST_WIDENED:
                wider[list(places)] *= float(np.quantile(off, 0.9)) / SPAN_DEVIATIONS


@torch.inference_mode()
def motion_scores(beliefs: Beliefs, labels: Sequence[MotionLabel]) -> dict[str, float]:
    """Return how beliefs fare on the readable components that are graded.

    Shares: of senses of turns and ways of slides that are right, of components that move of which
    that is told the right way, of components at rest that are told to move, of clips that turn and
    slide of which both are right, of amounts within `core.tolerance`, and of spans of nine in ten
    that hold the true one.
    """
    truths = [component_truth(label) for label in labels]
    hits: dict[str, list[bool]] = {}
    moves = beliefs.moves > 0
    for row, truth in enumerate(truths):
        for place, component in enumerate(COMPONENTS):
            if truth.moves[component] is False and truth.is_touched:
                hits.setdefault(f"{component} false", []).append(bool(moves[row, place]))
    ways: dict[int, dict[Component, bool]] = {}
    for amount in believed_amounts(beliefs, truths):
        component = amount.component
        ways.setdefault(amount.row, {})[component] = amount.is_way_right
        is_right = within_tolerance(amount.believed, amount.true, UNITS[component])
        hits.setdefault(f"{component} way", []).append(amount.is_way_right)
        is_seen = bool(moves[amount.row, COMPONENTS.index(component)])
        hits.setdefault(f"{component} seen", []).append(is_seen and amount.is_way_right)
        hits.setdefault(f"{component} amount", []).append(is_right)
        is_held = amount.deviations_off <= SPAN_DEVIATIONS
        hits.setdefault(f"{component} span", []).append(is_held)
    both = (Component.TURN, Component.SLIDE)
    hits["both ways"] = [
        right[both[0]] and right[both[1]] for right in ways.values() if set(both) <= set(right)
    ]
    hits = {name: values for name, values in hits.items() if values}
    return {name: float(np.mean(values)) for name, values in sorted(hits.items())} | {
        f"{name}, number": len(values) for name, values in sorted(hits.items())
    }
