"""What is believed of a clip's motion: one value, computed once, that every answer starts from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import BACKWARDS, Edit, opposite
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import BARELY_MM, BARELY_PX, COMPONENTS, WAYS, Component, Twist

Floats = NDArray[np.float64]
Spread = Floats

BELIEF_NUMBERS = 42
"""Of a Belief in one vector, as the language model reads it."""


@dataclass(frozen=True, eq=False)
class Belief:
    """The motion from a clip's first frame to its last, and how sure each part of it is."""

    mean: Twist  # the twist, lengths in pixels of the 224-pixel image and mm into the gel
    covariance: Spread  # of turn (degrees), right, down (pixels) and inward (mm), (4, 4)
    # Probability that a component moves, beyond this clip's noise, and goes that way, of all eight
    # ways; what is missing to 1 of a component is that no motion of it is seen.
    ways: Mapping[Motion, float]
    contact: float  # probability that something touches the gel
    radius_px: float  # radius of the contact, at which a turn's path is measured
    # Whether the picture tells each component at all: an edge hides its travel along itself, a
    # smooth ball its turn.
    readable: Mapping[Component, bool]
    # Detection limit: path that each component needs to be told from this clip's own noise, pixels,
    # of a press mm; none where it is not known.
    limits: Mapping[Component, float] = field(default_factory=dict)
    # Whether the gel's untouched look is known, without which nothing tells contact.
    is_contact_known: bool = True

    def moves(self, component: Component) -> float:
        """Return the probability that a component moves."""
        # Summed exactly: seen backwards the ways change places, and the sum must not.
        return math.fsum(self.ways[way] for way in WAYS[component])

    def way(self, component: Component) -> Motion:
        """Return the likeliest way of a component, given that it moves."""
        return max(WAYS[component], key=self.ways.__getitem__)

    def share(self, way: Motion, component: Component) -> float:
        """Return the probability of a way, given that its component counts."""
        total = self.moves(component)
        return self.ways[way] / total if total > 0 else 1 / len(WAYS[component])

    def amount(self, component: Component) -> float:
        """Return how far a component goes: degrees, pixels or mm, not negative."""
        return {
            Component.TURN: abs(self.mean.turn_deg),
            Component.SLIDE: self.mean.slide_px,
            Component.PRESS: abs(self.mean.inward_mm),
        }[component]

    def deviation(self, component: Component) -> float:
        """Return the standard deviation of `amount`, in its unit; of a slide along its way."""
        if component is not Component.SLIDE:
            place = 0 if component is Component.TURN else 3
            return math.sqrt(float(self.covariance[place, place]))
        way = np.array([self.mean.right_px, self.mean.down_px])
        length = float(np.hypot(*way))
        axis = way / length if length > 0 else np.array([1.0, 0.0])
        return math.sqrt(float(axis @ self.covariance[1:3, 1:3] @ axis))

    def path(self, component: Component) -> float:
        """Return how far a component moves the imprint: pixels, of a press mm."""
        return self.mean.path(component, self.radius_px)

    @property
    def at_limit(self) -> Belief:
        """The same with each component as far as its detection limit, 0 where that is unknown."""
        turn, slide, press = (self.limits.get(component, 0.0) for component in COMPONENTS)
        mean = Twist(math.degrees(turn / max(self.radius_px, 1.0)), slide, 0.0, press)
        return replace(self, mean=mean)

    def is_barely(self, component: Component) -> bool:
        """Tell whether a component goes so little that it is said to move barely."""
        least = BARELY_MM if component is Component.PRESS else BARELY_PX
        return self.path(component) < least

    def by_size(self) -> list[Component]:
        """Return the components that more probably count than not, the larger path first.

        A press is compared by the pixels that its depth makes a contact's rim move, about as many
        as its depth is wide.
        """
        paths = {c: self.path(c) for c in COMPONENTS if self.moves(c) >= 0.5}
        if Component.PRESS in paths:
            paths[Component.PRESS] *= PX_PER_MM
        return sorted(paths, key=paths.__getitem__, reverse=True)

    def seen(self, edit: Edit) -> Belief:
        """Return what is believed from another point of view."""
        ways = {edit.of_way(way): share for way, share in self.ways.items()}
        covariance = edit.matrix @ self.covariance @ edit.matrix.T
        mean = edit.of_twist(self.mean)
        return replace(self, mean=mean, covariance=covariance, ways=ways)

    def vector(self) -> Floats:
        """Return all that answers are decided by in one vector, for the tactile prefix.

        Returns:
            (BELIEF_NUMBERS,), unitless, most of them between -3 and 3: signed paths, deviations,
            amounts, detection limits, probabilities of ways, and what is decided of components.
        """
        turn, right, down, inward = astuple(self.mean)
        arc, deviations = math.radians(turn) * self.radius_px, np.sqrt(np.diag(self.covariance))
        to_px = np.array([PX_PER_MM if c is Component.PRESS else 1.0 for c in COMPONENTS])
        lengths = to_px * [self.path(c) for c in COMPONENTS]
        limits = to_px * [self.limits.get(c, 0.0) for c in COMPONENTS]
        moves = np.array([self.moves(c) for c in COMPONENTS])
        by_size = {component: -place for place, component in enumerate(self.by_size())}
        ranks = np.array([by_size.get(c, -len(COMPONENTS)) for c in COMPONENTS])
        angle = math.atan2(down, right)
        parts = (
            np.arcsinh([2 * arc, turn, 2 * right, 2 * down, inward / 0.05]),
            np.log(np.maximum(deviations, 1e-4)),
            np.log(lengths + 0.03),
            np.log(limits + 0.03),
            [2 * self.ways[way] - 1 for c in COMPONENTS for way in WAYS[c]],
            np.clip(20 * (moves - 0.5), -1, 1),
            np.sign(ranks[[0, 0, 1]] - ranks[[1, 2, 2]]),
            [1.0 if self.is_barely(c) else -1.0 for c in COMPONENTS],
            [1.0 if self.readable[c] else -1.0 for c in COMPONENTS],
            # Of a slide by its way, and by where between two it is told to go both.
            [math.cos(angle), math.sin(angle), math.cos(4 * angle), math.sin(4 * angle)],
            [2 * self.contact - 1, 1.0 if self.is_contact_known else -1.0],
            [math.log(max(self.radius_px, 1.0)) - 3],
        )
        return np.concatenate(parts)


def fused(belief: Belief, backwards: Belief) -> Belief:
    """Return what a clip and the same clip played backwards make one believe of its turn and slide.

    A motion turns round with the clip; what a growing contact looks like does not, and cancels.
    How far the two are apart widens the spread. A way that only one of them finds hardly counts;
    one that both find is told, however far apart they are in how far.
    Press and contact stay as they are.
    """
    other = backwards.seen(BACKWARDS)
    one, two = (np.array([x.turn_deg, x.right_px, x.down_px]) for x in (belief.mean, other.mean))
    turn, right, down = ((one + two) / 2).tolist()
    gap = np.append(one - two, 0.0)
    ways = dict(belief.ways)
    for component in (Component.TURN, Component.SLIDE):
        # Of two opposite ways one is wrong at least.
        weight = 0.5 if belief.way(component) is opposite(other.way(component)) else 1.0
        for way in WAYS[component]:
            ways[way] = weight * math.sqrt(belief.ways[way] * other.ways[way])
    limits = {part: max(own, other.limits.get(part, own)) for part, own in belief.limits.items()}
    both = replace(
        belief,
        mean=Twist(turn, right, down, belief.mean.inward_mm),
        covariance=(belief.covariance + other.covariance + np.outer(gap, gap)) / 2,
        ways=ways,
        limits=limits,
    )
    alone = replace(both, covariance=(belief.covariance + other.covariance) / 2)
    for component, part in ((Component.TURN, slice(0, 1)), (Component.SLIDE, slice(1, 3))):
        is_seen_twice = min(belief.moves(component), other.moves(component)) >= 0.5
        if is_seen_twice and belief.way(component) is other.way(component):
            continue
        moves, own = both.moves(component), alone.deviation(component)
        apart = float(np.linalg.norm(gap[part])) / 2**0.5
        reaches_zero = SPAN_DEVIATIONS * math.hypot(apart, own) > both.amount(component)
        if moves >= 0.5 and reaches_zero and apart > own:
            # Forwards and backwards are so far apart that it may as well be at rest.
            ways |= {way: ways[way] * UNTOLD / moves for way in WAYS[component]}
    return replace(both, ways=ways)


def kept_from_zero(belief: Belief) -> Belief:
    """Return a belief no span of which reaches zero where a turn or a slide is told."""
    covariance = belief.covariance.copy()
    for component, part in ((Component.TURN, slice(0, 1)), (Component.SLIDE, slice(1, 3))):
        far, amount = SPAN_DEVIATIONS * belief.deviation(component), belief.amount(component)
        if belief.moves(component) >= 0.5 and far > MOST_OF_AMOUNT * amount > 0:
            covariance[part, part] *= (MOST_OF_AMOUNT * amount / far) ** 2
    return replace(belief, covariance=covariance)


MOST_OF_AMOUNT = 0.95
"""Half of a span of nine in ten as a share of an amount that is told, at the most."""

SPAN_DEVIATIONS = 1.645
"""Half of a span of nine in ten."""

UNTOLD = 0.49
"""Probability of a motion that is not told, at the most."""


PX_PER_MM = 12.8
"""Pixels of the 224-pixel image per mm on a GelSight Mini, the mean of both axes."""
