"""A robust mixture of what is measured, and a small network that may bend it, made into a Belief.

Candidates that disagree beyond their spreads are not averaged: the best supported of them and those
that agree with it are. What is told from noise is decided by this alone. A network learns how far
to trust each and how much of a motion they miss, within bounds, so that nothing learned turns a
measured motion round; and far from what it has seen, it is left out.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.backbone.motions import MEASURED
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import BARELY_PX, COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import MOST_OF_AMOUNT, SPAN_DEVIATIONS, Belief
from geotlm_lm.motion.measured import CANDIDATES, Measured

HIDDEN, DROPOUT = 192, 0.1

RELIEF_CHAINED = MEASURED.index("relief_chained")

TURN_NOISE = (4.0, 11.0, 4.5, 9.0, 1.0)
SLIDE_NOISE = (3.6, 10.0, 5.0, 9.0, 1.0)
"""Deviation of each candidate, in those of white noise: what codecs, lamps and warps add. So large
that 95 of 100 held imprints stay below 1.96 of them."""

_NOISE = torch.tensor([TURN_NOISE, SLIDE_NOISE, SLIDE_NOISE]).T

LEAST_NOISE_PX = torch.tensor(0.01)

PRIOR_GATE = torch.tensor([3.0, 1.0, 0.5, 0.0, 0.0])
"""Logits of the candidates before anything is learned, and far from what was seen."""

GATE_REACH = 2.0
"""Most by which a logit is learned to differ."""

AGREEING = 0.25
"""Share of the smaller by which two candidates may differ beside their noise and still agree."""

SHARE_OF_PATH = 0.1
"""Deviation of any candidate as a share of its path, where they are weighed."""

LOG_GAIN = (math.log(0.7), math.log(1.5))
"""Bounds of what is missing of a measured path: a pad holds back a part of every turn."""

CARRIED = 0.5
"""Most of a turn's path by which the middle of a contact, wrongly placed, seems to slide."""

LEAKING, GROWING_PX = 0.015, 0.35
"""Share of a turn's path, or a slide's, that may look as the other; and path of either that an
imprint whose contrast grows by a factor of e may seem to make."""

MIDDLE_PX = 7.0
"""Deviation of where the middle of a contact is believed, about which a turn that is none of the
object's seems to slide: of 18 simulated turns of 5 degrees and more without a slide 97 % seem to
slide by less than 14 pixels a radian, of 854 half by 8 more or less than they do."""

RELATIVE, UNKNOWN_RELATIVE = (0.03, 1.0), 0.2
"""Bounds of an amount's deviation as a share of it, and what it is far from what was seen."""

LEAST_MM, PRESS_SCALE_MM = 0.01, 0.2

SIGNIFICANT = (2.9, 2.9, 1.0)
"""Path over its noise from which on a turn, a slide and a press are significant, at the least: of
344 real imprints held (half `tune`) three reach 2.8 in a turn or a slide, of 792 of both halves one
3.3. Of a press, which is learned, training raises it until false alarms are as rare as asked."""

MOST_OF_PATH = MOST_OF_AMOUNT / SPAN_DEVIATIONS
"""Deviation of an amount that is significant as a share of it, at the most: its span of nine in ten
does not reach zero then, as the measurement tells that the motion does not."""

STEEPNESS = 5.0
"""Of the probability that a component moves against the log of its significance."""

AXES = 24
"""Directions in which hints of training vary most, and their distance is taken."""

READABLE = 0.5
"""Probability from which a component counts as readable."""

_AXIS_COUNTS = torch.tensor([1.0, 2.0])
"""Numbers of a turn and of a slide."""

_OUTPUTS = {
    "gates": 2 * CANDIDATES,
    "gains": 2,
    "carried": 2,
    "relative": 2,
    "inward": 1,
    "inward_deviation": 1,
    "contact": 1,
    "readable": 3,
}


_NAMES_OF = {
    "gate": "gates",
    "gains": "gains",
    "carried": "carried",
    "deviations": "relative",
}
"""Output of each part that can be left out: at 0 it changes nothing."""


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What is believed of b clips."""

    # Turn at the contact's radius, right and down, pixels of the 224-pixel image, (b, 3).
    path: Tensor
    inward_mm: Tensor  # approach, (b,)
    noise: Tensor  # deviation of the three paths and the approach where nothing moves, (b, 4)
    deviation: Tensor  # their deviation as amounts, noise included, (b, 4)
    # How far turn, slide and press go, in deviations of their noise, (b, 3); 0 of what is learned
    # to go another way than was measured.
    significance: Tensor
    sense: Tensor  # probability that it turns clockwise if it turns, (b,)
    contact: Tensor  # logit that something touches, (b,)
    readable: Tensor  # logits that each component can be read, (b, 3)
    least: Tensor  # significance from which on turn, slide and press are believed, (3,)
    turn_weights: Tensor  # of the candidates in the turn, (b, CANDIDATES)
    slide_weights: Tensor  # of them in the slide, likewise
    radius_px: Tensor  # of the contact, (b,)

    def only(self, rows: Tensor | slice) -> Beliefs:
        """Return those of some clips."""
        kept = {name: value[rows] for name, value in vars(self).items() if name != "least"}
        return Beliefs(**kept, least=self.least)

    @property
    def weights(self) -> Tensor:
        """Mean weight of each candidate in turn and slide, (b, CANDIDATES)."""
        return (self.turn_weights + self.slide_weights) / 2

    @property
    def lengths(self) -> Tensor:
        """Turn and slide in pixels, and press in mm, not negative, (b, 3)."""
        slide = self.path[:, 1:].norm(dim=1, keepdim=True)
        return torch.cat([self.path[:, :1].abs(), slide, self.inward_mm.abs()[:, None]], dim=1)

    def along(self, deviation: Tensor) -> Tensor:
        """Return deviations (b, 4) of turn, slide along its way, and press, (b, 3)."""
        # At rest any way does: the diagonal.
        way = self.path[:, 1:].abs() + 1e-6
        slide = (way * deviation[:, 1:3]).norm(dim=1, keepdim=True) / way.norm(dim=1, keepdim=True)
        return torch.cat([deviation[:, :1], slide, deviation[:, 3:]], dim=1)

    @property
    def limits(self) -> Tensor:
        """How far turn, slide (pixels) and press (mm) have to go to be significant, (b, 3)."""
        return self.least * self.along(self.noise)

    @property
    def stated(self) -> Tensor:
        """The deviations of what is significant kept so small that no span reaches zero, (b, 4)."""
        most = torch.where(self.significance >= self.least, MOST_OF_PATH * self.lengths, torch.inf)
        return torch.minimum(self.deviation, most.index_select(1, _PART_OF.to(most.device)))

    @property
    def moves(self) -> Tensor:
        """Logits that turn, slide and press are there, (b, 3): that each is significant."""
        return STEEPNESS * (self.significance / self.least).clamp(min=1e-3).log()

    def quarters(self) -> Tensor:
        """Return the probabilities that a slide goes right, down, left, up, (b, 4).

        What lies across the way is normal, so that the angle is nearly.
        """
        right, down = self.path[:, 1], self.path[:, 2]
        length = torch.hypot(right, down).clamp(min=1e-3)
        across = (self.deviation[:, 1] * down / length).square()
        across = (across + (self.deviation[:, 2] * right / length).square()).sqrt()
        spread = torch.atan2(across, length).clamp(min=0.02)
        angle = torch.atan2(down, right)
        off = torch.remainder(angle[:, None] - _QUARTERS.to(angle.device) + math.pi, 2 * math.pi)
        # An edge of a quarter may be met the other way round the circle as well.
        beyond = _EDGES.to(angle.device) - (off - math.pi)[:, None, None]
        below, above = torch.erf(beyond / (spread * math.sqrt(2))[:, None, None, None]).unbind(1)
        mass = (above - below).sum(dim=1) / 2
        mass = mass.clamp(min=1e-6)
        return mass / mass.sum(dim=1, keepdim=True)


_PART_OF = torch.tensor([0, 1, 1, 2])
"""Turn, slide or press that turn, right, down and inward are of."""

_QUARTERS = torch.arange(4) * (math.pi / 2)
"""Angles of right, down, left and up."""

_EDGES = torch.tensor([[-0.25], [0.25]]) * math.pi + torch.tensor([-2.0, 0.0, 2.0]) * math.pi
_EDGES = _EDGES[..., None]
"""Both edges of a quarter about its middle, each time round the circle, (2, 3, 1)."""


@dataclass(frozen=True, eq=False)
class Mixed:
    """A robust mean of candidates."""

    value: Tensor  # (..., d)
    spread: Tensor  # deviation of those that agree about it, (...)
    noise: Tensor  # deviation of it by noise, (..., d)
    shares: Tensor  # how far each candidate is trusted, (..., k)
    alike: Tensor  # how well each agrees with the one that is best supported, 0 to 1, (..., k)
    weights: Tensor  # of each in the mean, (..., k)


class Candidates:
    """Candidates (..., k, d) with deviations likewise, of which robust means are made.

    Of a mixture of bells the mode with the most mass is kept: the product of those that agree. Of d
    numbers some may be 0 throughout, in values and deviations; `axes` (...) counts those that are
    not, where that is not all of them.
    """

    def __init__(self, values: Tensor, noise: Tensor, axes: Tensor | None = None) -> None:
        self._values, self._noise = values, noise
        self._axes = values.new_full((), values.shape[-1]) if axes is None else axes
        self._sizes = values.norm(dim=-1)
        self._variance = noise.square().sum(dim=-1) / self._axes[..., None]
        smaller = torch.minimum(self._sizes[..., None], self._sizes[..., None, :])
        allowed = self._variance[..., None] + self._variance[..., None, :]
        allowed = allowed + (AGREEING * smaller).square()
        apart = (values[..., None, :] - values[..., None, :, :]).square().sum(dim=-1)
        self._agree = 1 / (1 + apart / allowed)

    def mixed(self, gate: Tensor) -> Mixed:
        """Return their robust mean by logits (..., k)."""
        shares, values = gate.softmax(dim=-1), self._values
        support = (self._agree * shares[..., None, :]).sum(dim=-1) * shares.sqrt()
        mode = support.argmax(dim=-1, keepdim=True)
        alike = self._agree.take_along_dim(mode[..., None], dim=-2).squeeze(-2)
        path = SHARE_OF_PATH * self._sizes.take_along_dim(mode, dim=-1)
        weights = shares * alike / (self._variance + path.square())
        weights = weights / weights.sum(dim=-1, keepdim=True)
        value = (weights[..., None] * values).sum(dim=-2)
        off = (values - value[..., None, :]).square().sum(dim=-1)
        # What they share is no independent noise: the mean is no surer than those it is made of.
        own = (weights[..., None] * self._noise).sum(dim=-2)
        spread = ((weights * off).sum(dim=-1) / self._axes + 1e-8).sqrt()
        return Mixed(value, spread, own, shares, alike, weights)


class MotionNetwork(nn.Module):
    """Turn what is measured into what is believed.

    Its deviations are widened so that spans hold nine in ten on objects that it has not seen, where
    a relief is measured and where dots stand in its place.
    """

    PARTS = tuple(_NAMES_OF)
    """What is learned of a turn and a slide, each of which can be left out."""

    def __init__(self, hints: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(hints))
        self.register_buffer("scale", torch.ones(hints))
        self.register_buffer("axes", torch.zeros(AXES, hints))
        self.register_buffer("reach", torch.tensor(math.inf))
        self.register_buffer("widening", torch.ones(2, 4))  # where a relief is measured, and not
        self.register_buffer("least", torch.tensor(SIGNIFICANT))
        self.layers = nn.Sequential(
            nn.Linear(hints, HIDDEN),
            nn.GELU(),
            nn.Dropout(DROPOUT),
            nn.Linear(HIDDEN, HIDDEN),
            nn.GELU(),
            nn.Dropout(DROPOUT),
        )
        self.out = nn.Linear(HIDDEN, sum(_OUTPUTS.values()))
        nn.init.zeros_(self.out.weight)
        nn.init.zeros_(self.out.bias)
        self.left_out = ""

    def without(self, part: str) -> MotionNetwork:
        """Return this network with one of `PARTS` as before training."""
        other = copy(self)
        other.left_out = part
        return other

    @torch.no_grad()
    def see(self, hints: Tensor) -> None:
        """Take the hints of training (n, hints) for what is familiar."""
        self.mean.copy_(hints.mean(dim=0))
        self.scale.copy_(hints.std(dim=0, correction=0).clamp(min=1e-3))
        standard = self._standard(hints)
        count = min(AXES, *standard.shape)
        _, sizes, axes = torch.linalg.svd(standard, full_matrices=False)
        self.axes.zero_()
        deviations = sizes[:count, None] / len(hints) ** 0.5
        self.axes[:count] = axes[:count] / deviations.clamp(min=1e-3)
        self.reach.copy_(torch.quantile(self._distance(standard), 0.99))

    def _standard(self, hints: Tensor) -> Tensor:
        return ((hints - self.mean) / self.scale).clamp(-8, 8)

    def _distance(self, standard: Tensor) -> Tensor:
        return (standard @ self.axes.T).square().mean(dim=1).sqrt()

    def forward(self, measured: Measured) -> Beliefs:
        """Return what is believed of b clips.

        Turn and slide are worked out side by side, in parts (b, 2, 2): (0, turn), (right, down).
        """
        standard = self._standard(measured.hints)
        own = self._learned(standard)
        # How near they are to the hints of training, from 0 to 1.
        familiar = (2 - self._distance(standard)[:, None] / self.reach).clamp(0, 1)
        white = measured.white.clamp(min=1e-4)
        device = white.device
        noise = torch.hypot(_NOISE.to(device) * white, LEAST_NOISE_PX)
        parts = (F.pad(each, (1, 0)).unflatten(2, (2, 2)) for each in (measured.paths, noise))
        parts = (each.transpose(1, 2) for each in parts)
        candidates = Candidates(*parts, _AXIS_COUNTS.to(device))
        prior = torch.where(measured.is_measured, PRIOR_GATE.to(device), -torch.inf)
        prior = prior[:, None]
        plain = candidates.mixed(prior)
        sizes = plain.value.norm(dim=2)
        # The simulator's clips seldom move by less than a pixel: what it teaches is used beyond.
        trust = familiar * (sizes.detach() / BARELY_PX).clamp(max=1)
        # What a pad holds back is learned where shading shows the object. Dots show the gel, and no
        # picture tells how far it lags behind: of 54 real slides on dots (half `tune`) 0.33 were
        # within tolerance of how far the dots went, 0.85 are by the plain mixture.
        trust = trust * measured.is_measured[:, RELIEF_CHAINED, None]
        gates = GATE_REACH * torch.tanh(own["gates"]).unflatten(1, (2, CANDIDATES))
        bent = candidates.mixed(prior + trust[..., None] * gates)
        bend = torch.tanh(own["gains"]) * trust
        gains = torch.where(bend > 0, LOG_GAIN[1] * bend, -LOG_GAIN[0] * bend).exp()
        turned, slid = (gains[..., None] * bent.value).unbind(1)
        # Of 1,023 simulated turns of other objects the plain mixture knows the sense of 0.931, what
        # is learned of 0.926: which way is measured, how far is learned.
        is_kept = (bent.value * plain.value)[:, 0, 1:] > 0
        turned = torch.where(is_kept, turned, plain.value[:, 0])
        carried = CARRIED * trust[:, :1] * torch.tanh(own["carried"]) * turned[:, 1:]
        path = torch.stack([turned, slid + carried], dim=1)
        inward = PRESS_SCALE_MM * own["inward"].squeeze(1)
        off_mm = LEAST_MM + PRESS_SCALE_MM * own["inward_deviation"].clamp(-6, 2).exp()
        stillness = self._noise(measured, plain, sizes)
        relative = _between(own["relative"], RELATIVE, UNKNOWN_RELATIVE, trust)
        clear = _clear(plain.value, stillness, path)
        path = self._beyond_limits(path, stillness, clear)
        amount = torch.hypot(relative * path.norm(dim=2), bent.spread)[..., None].expand_as(path)
        path, stillness, amount = (each.flatten(1)[:, 1:] for each in (path, stillness, amount))
        wider = self.widening[(~measured.is_measured[:, RELIEF_CHAINED]).long()]
        wide = torch.hypot(stillness, wider[:, :3] * amount)
        return Beliefs(
            path=path,
            inward_mm=inward,
            noise=torch.cat([stillness, off_mm], dim=1),
            deviation=torch.cat([wide, off_mm * wider[:, 3:]], dim=1),
            significance=torch.cat([clear, inward.abs()[:, None] / off_mm], dim=1),
            sense=_sense(measured.paths[..., 0], bent, path[:, 0] / stillness[:, 0]),
            contact=own["contact"].squeeze(1),
            readable=own["readable"],
            least=self.least,
            turn_weights=bent.weights[:, 0],
            slide_weights=bent.weights[:, 1],
            radius_px=measured.radius_px,
        )

    def _learned(self, standard: Tensor) -> dict[str, Tensor]:
        outputs = self.out(self.layers(standard))
        own = dict(zip(_OUTPUTS, outputs.split(list(_OUTPUTS.values()), dim=1), strict=True))
        if self.left_out:
            name = _NAMES_OF[self.left_out]
            own[name] = torch.zeros_like(own[name])
        return own

    def _beyond_limits(self, path: Tensor, noise: Tensor, clear: Tensor) -> Tensor:
        """Return paths, in parts, that are at their limit, where it is learned they cross it.

        Whether turn and slide are significant was decided by what was measured, `clear` (b, 2).
        """
        sizes = path.norm(dim=2).clamp(min=1e-6)
        limits = self.least[:2] * (path * noise).norm(dim=2) / sizes
        is_seen = clear >= self.least[:2]
        kept = torch.where(is_seen, torch.maximum(sizes, limits), torch.minimum(sizes, limits))
        return path * (kept / sizes)[..., None]

    def _noise(self, measured: Measured, plain: Mixed, sizes: Tensor) -> Tensor:
        """Return the deviation of turn, right and down where neither turns or slides, in parts."""
        # What the other component, and a growing contact, make of a picture is no motion.
        other = (LEAKING * sizes.flip(1)).square()
        turn_rad = plain.value[:, 0, 1:] / measured.radius_px[:, None]
        other = other + F.pad(MIDDLE_PX * turn_rad, (1, 0)).square()
        grown = (GROWING_PX * measured.growth[:, None]).square()
        seen = plain.spread.square() + other + grown
        return (plain.noise.square() + seen[..., None]).sqrt()


def _clear(measured: Tensor, noise: Tensor, path: Tensor) -> Tensor:
    """Return measured paths in deviations of their noise, 0 where believed ones go back, (b, 2).

    The noise is that along their way; all are in parts.
    """
    sizes = measured.norm(dim=2)
    along = (measured * noise).norm(dim=2) / sizes.clamp(min=1e-6)
    is_kept = (measured * path).sum(dim=2) > 0
    return torch.where(is_kept, sizes / along.clamp(min=1e-6), 0.0)


def _between(raw: Tensor, bounds: tuple[float, float], unknown: float, trust: Tensor) -> Tensor:
    """Return what is learned between bounds, 0 being `unknown`, which it is without trust."""
    low, high = bounds
    start = math.log((unknown - low) / (high - unknown))
    return low + (high - low) * torch.sigmoid(start + trust * raw)


def _sense(paths: Tensor, mixed: Mixed, beyond: Tensor) -> Tensor:
    """Return the probability that a turn is clockwise: of what agrees, and of what does not."""
    agreeing = 0.5 * (1 + torch.erf(beyond / 2**0.5))
    kept = mixed.shares[:, 0] * mixed.alike[:, 0]
    lost = mixed.shares[:, 0] - kept
    sense = kept.sum(dim=1) * agreeing + (lost * (paths > 0)).sum(dim=1)
    return sense.clamp(1e-4, 1 - 1e-4)


def belief_of_one(beliefs: Beliefs, place: int = 0, *, doubt: float = 1.0) -> Belief:
    """Return what is believed of one of the clips as a value to answer from.

    Doubt multiplies noise and spread, and flattens the probabilities.
    """
    own = beliefs.only(slice(place, place + 1))
    own = replace(
        own,
        deviation=own.deviation * doubt,
        noise=own.noise * doubt,
        significance=own.significance / doubt,
    )
    own = replace(own, deviation=own.stated)
    turn, slide, press = map(_sigmoid, own.moves[0].tolist())
    right, down, left, up = own.quarters()[0].tolist()
    sense, contact, inward_mm, radius = (
        each.item() for each in (own.sense, own.contact, own.inward_mm, own.radius_px)
    )
    path, deviation = (each[0].double().numpy() for each in (own.path, own.deviation))
    clockwise = _sigmoid(math.log(sense / (1 - sense)) / doubt)
    inward = 0.5 * (1 + math.erf(inward_mm / deviation[3] / (2**0.5 * doubt)))
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
    to_degrees = math.degrees(1 / radius)
    readable = [_sigmoid(logit) >= READABLE for logit in own.readable[0].tolist()]
    return Belief(
        mean=Twist(path[0] * to_degrees, path[1], path[2], inward_mm),
        covariance=np.diag((deviation * (to_degrees, 1.0, 1.0, 1.0)) ** 2),
        ways=ways,
        contact=_sigmoid(contact / doubt),
        radius_px=radius,
        readable=dict(zip(Component, readable, strict=True)),
        limits=dict(zip(COMPONENTS, own.limits[0].tolist(), strict=True)),
    )


def _sigmoid(logit: float) -> float:
    return 0.5 * (1 + math.tanh(logit / 2))
