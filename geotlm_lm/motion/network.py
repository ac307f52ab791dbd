"""A small network that fuses what is measured of a motion into a Belief.

Its mean is a weighted mean of the measured motions, times a gain, plus a correction: before
training it equals the measured fusion, and what it learns is which measurement to trust, how much
of the motion each finds, how far off it may be, and which components count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor, nn

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.motion.measured import CANDIDATES, Measured

HIDDEN = 192

GREEN_CHAINED, GREEN_DIRECT = 0, 1
START_WEIGHT = 2.0
"""Log of how much more the motions found in the residual weigh before training."""

FLOOR_PX, SHARE_OF_PATH = 0.25, 0.05
"""Least deviation of a path that is told: the noise of pairs of real frames, and a share of it."""

FLOOR_MM = 0.02

PRESS_SCALE_MM = 0.2

READABLE = 0.5
"""Probability from which a component counts as readable."""

BELIEF_NUMBERS = 18
"""Of a Belief in one vector, as the language model reads it."""

_OUTPUTS = {
    "turn_weights": CANDIDATES,
    "slide_weights": CANDIDATES,
    "gains": 2,
    "corrections": 3,
    "inward": 1,
    "deviations": 4,
    "counts": 3,
    "press_in": 1,
    "contact": 1,
    "readable": 3,
}


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What the network believes of b clips, before it is told."""

    # Turn at the contact's radius, right and down, pixels of the 224-pixel image, (b, 3).
    path: Tensor
    inward_mm: Tensor  # approach, (b,)
    deviation: Tensor  # of the three paths and the approach, (b, 4)
    counts: Tensor  # logits that turn, slide and press count, (b, 3)
    press_in: Tensor  # logit that a press that counts goes in, (b,)
    contact: Tensor  # logit that something touches, (b,)
    readable: Tensor  # logits that each component can be read, (b, 3)
    radius_px: Tensor  # of the contact, (b,)

    def sense(self) -> Tensor:
        """Return the logit that a turn that counts goes clockwise, (b,)."""
        return SENSE_SHARPNESS * self.path[:, 0] / self.deviation[:, 0]

    def quarters(self) -> Tensor:
        """Return the probabilities that a slide that counts goes right, down, left, up, (b, 4).

        What lies across the way is normal, so that the angle is nearly.
        """
        right, down = self.path[:, 1], self.path[:, 2]
        length = torch.hypot(right, down).clamp(min=1e-3)
        across = (self.deviation[:, 1] * down / length).square()
        across = (across + (self.deviation[:, 2] * right / length).square()).sqrt()
        spread = torch.atan2(across, length).clamp(min=0.02)
        angle = torch.atan2(down, right)
        middles = torch.arange(4, device=angle.device) * (math.pi / 2)
        off = torch.remainder(angle[:, None] - middles + math.pi, 2 * math.pi) - math.pi
        edge = math.pi / 4
        mass = _normal(edge - off, spread) - _normal(-edge - off, spread)
        for whole in (-2 * math.pi, 2 * math.pi):
            mass = mass + _normal(edge - off + whole, spread) - _normal(-edge - off + whole, spread)
        mass = mass.clamp(min=1e-6)
        return mass / mass.sum(dim=1, keepdim=True)

    def vector(self) -> Tensor:
        """Return it in one vector, (b, BELIEF_NUMBERS), for the language model's prefix."""
        return torch.cat(
            [
                torch.asinh(2 * self.path),
                torch.asinh(self.inward_mm / 0.05)[:, None],
                (self.path / self.deviation[:, :3]).clamp(-20, 20) / 5,
                (self.inward_mm / self.deviation[:, 3]).clamp(-20, 20)[:, None] / 5,
                self.deviation.log(),
                self.counts.clamp(-8, 8) / 4,
                self.press_in.clamp(-8, 8)[:, None] / 4,
                self.contact.clamp(-8, 8)[:, None] / 4,
                self.radius_px.log()[:, None] - 3,
            ],
            dim=1,
        )


SENSE_SHARPNESS = 2.4
"""From a Laplace error's standardised mean to a logit: log odds of its sign, about, near zero."""


def _normal(value: Tensor, spread: Tensor) -> Tensor:
    return 0.5 * (1 + torch.erf(value / (spread[:, None] * math.sqrt(2))))


class MotionNetwork(nn.Module):
    """Fuse what is measured.

    Its deviations are widened so that spans hold nine in ten on objects that it has not seen.
    """

    def __init__(self, hints: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(hints))
        self.register_buffer("scale", torch.ones(hints))
        self.register_buffer("widening", torch.ones(4))
        self.layers = nn.Sequential(
            nn.Linear(hints, HIDDEN),
            nn.GELU(),
            nn.Dropout(0.1),
            nn.Linear(HIDDEN, HIDDEN),
            nn.GELU(),
            nn.Dropout(0.1),
        )
        self.out = nn.Linear(HIDDEN, sum(_OUTPUTS.values()))

    @torch.no_grad()
    def start_at_measured(self) -> None:
        """Let what is told be what is measured: nothing is learned yet."""
        nn.init.zeros_(self.out.weight)
        nn.init.zeros_(self.out.bias)
        self.out.bias[[GREEN_CHAINED, GREEN_DIRECT]] = START_WEIGHT
        self.out.bias[[CANDIDATES + GREEN_CHAINED, CANDIDATES + GREEN_DIRECT]] = START_WEIGHT

    def forward(self, measured: Measured) -> Beliefs:
        """Return what is believed of b clips."""
        standard = ((measured.hints - self.mean) / self.scale).clamp(-8, 8)
        outputs = self.out(self.layers(standard)).split(list(_OUTPUTS.values()), dim=1)
        own = dict(zip(_OUTPUTS, outputs, strict=True))
        paths = measured.paths
        turn = (own["turn_weights"].softmax(dim=1) * paths[..., 0]).sum(dim=1)
        slide = (own["slide_weights"].softmax(dim=1)[..., None] * paths[..., 1:]).sum(dim=1)
        gains = own["gains"].clamp(-2, 2).exp()
        path = torch.cat([(turn * gains[:, 0])[:, None], slide * gains[:, 1:]], dim=1)
        path = path + own["corrections"]
        inward = PRESS_SCALE_MM * own["inward"].squeeze(1)
        lengths = torch.stack([path[:, 0].abs(), *[path[:, 1:].norm(dim=1)] * 2], dim=1)
        floor = FLOOR_PX + SHARE_OF_PATH * lengths.detach()
        relative = own["deviations"].clamp(-4, 4).exp()
        deviation = torch.cat([floor * relative[:, :3], FLOOR_MM * relative[:, 3:]], dim=1)
        deviation = deviation * self.widening
        return Beliefs(
            path,
            inward,
            deviation,
            own["counts"],
            own["press_in"].squeeze(1),
            own["contact"].squeeze(1),
            own["readable"],
            measured.radius_px,
        )


def belief_of_one(beliefs: Beliefs, place: int = 0, *, doubt: float = 1.0) -> Belief:
    """Return what is believed of one of the clips as a value to answer from.

    Doubt widens the spread and flattens the probabilities.
    """
    one = Beliefs(*(value[place : place + 1] for value in vars(beliefs).values()))
    numbers = tuple(one.vector()[0].tolist())
    one = replace(one, deviation=one.deviation * doubt)
    turn, slide, press = (one.counts[0] / doubt).sigmoid().double().tolist()
    clockwise, inward = float(one.sense().sigmoid()), float((one.press_in / doubt).sigmoid())
    right, down, left, up = one.quarters()[0].double().tolist()
    ways = {
        Motion.CLOCKWISE: turn * clockwise,
        Motion.COUNTERCLOCKWISE: turn * (1 - clockwise),
        Motion.RIGHT: slide * right,
        Motion.DOWN: slide * down,
        Motion.LEFT: slide * left,
        Motion.UP: slide * up,
        Motion.PRESS: press * inward,
        Motion.RELEASE: press * (1 - inward),
    }
    radius = float(one.radius_px)
    to_degrees = math.degrees(1 / radius)
    path, deviation = (each[0].double().numpy() for each in (one.path, one.deviation))
    readable = one.readable[0].sigmoid() >= READABLE
    return Belief(
        mean=Twist(path[0] * to_degrees, path[1], path[2], float(one.inward_mm)),
        covariance=np.diag((deviation * (to_degrees, 1.0, 1.0, 1.0)) ** 2),
        ways=ways,
        contact=float((one.contact / doubt).sigmoid()),
        radius_px=radius,
        readable=dict(zip(Component, readable.tolist(), strict=True)),
        numbers=numbers,
    )
