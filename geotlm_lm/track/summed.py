"""What a track comes to as a whole: the belief of its motion from the first frame to the last."""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, WAYS, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.track import STEPS_OF, Track

EDGE_FRAMES = 3
"""A press that begins no later after a touch, or ends so before it ends, is the touch's own."""

CLOCKWISE = {1: Motion.CLOCKWISE, -1: Motion.COUNTERCLOCKWISE}
INWARD = {1: Motion.PRESS, -1: Motion.RELEASE}

UNSEEN = 0.02
"""Probability that a component moves of which no event was found."""


def belief_of_track(track: Track, window: Belief) -> Belief:
    """Return the belief of the motion from a track's first frame to its last.

    `window` is the belief of the four frames of `window_of`, which the language model reads.
    """
    contact = float(track.contact.max(initial=0.0))
    own = np.outer(STEPS_OF, STEPS_OF) * track.covariances.sum(axis=0)
    doubt = np.square(track.systematic * track.twists.sum(axis=0)) + np.square(track.floors)
    ways: dict[Motion, float] = {}
    for component in COMPONENTS:
        moves = _moves(track, component) * (contact if track.is_contact_known else 1.0)
        ways |= {way: share * moves for way, share in _shares(track, component).items()}
    return replace(
        window,
        mean=track.net_twist,
        covariance=own + np.diag(doubt),
        ways=ways,
        contact=contact,
        radius_px=track.middle_radius_px or window.radius_px,
        limits=track.limits,
        is_contact_known=track.is_contact_known,
    )


def _moves(track: Track, component: Component) -> float:
    """Return how probable it is that a component moves in a track that is touched."""
    if component is Component.PRESS and not track.is_contact_known:
        return 0.0
    events = [event for event in track.of(component) if event.component is component]
    if component is Component.PRESS:
        # What begins or ends contact is a touch or a release and no press.
        events = [event for event in events if not is_edge(track, event)]
    return max((event.probability for event in events), default=UNSEEN)


def is_edge(track: Track, event: Event) -> bool:
    """Tell whether a press or release is the beginning or the end of a contact."""
    begins = [event.begin for event in track.events if event.kind is EventKind.TOUCH]
    if event.kind is EventKind.PRESS:
        return any(0 <= event.begin - begin <= EDGE_FRAMES for begin in begins)
    place = int(np.searchsorted(track.numbers, event.end))
    after = track.contact[place : place + EDGE_FRAMES + 1]
    return bool((after < 0.5).any())


def _shares(track: Track, component: Component) -> dict[Motion, float]:
    """Return the probability of each way of a component, given that it moves."""
    if component is Component.SLIDE:
        return _quarters(track.twists.sum(axis=0)[1:3], track.net(component).deviation)
    net, events = track.net(component), track.of(component)
    mean = net.mean
    if component is Component.PRESS and events:
        largest = max(events, key=lambda event: abs(event.amount.mean))
        mean = largest.amount.mean
    sure = NormalDist().cdf(mean / max(net.deviation, 1e-6))
    named = CLOCKWISE if component is Component.TURN else INWARD
    return {named[1]: sure, named[-1]: 1 - sure}


def _quarters(way: np.ndarray, deviation: float) -> dict[Motion, float]:
    """Return how probable it is that a travel lies in each quarter of the image."""
    spread = max(math.atan2(deviation, float(np.hypot(*way))), 0.02)
    angle = math.atan2(way[1], way[0])
    bell, shares = NormalDist(0.0, spread), {}
    for place, motion in enumerate((Motion.RIGHT, Motion.DOWN, Motion.LEFT, Motion.UP)):
        off = math.remainder(angle - place * math.pi / 2, 2 * math.pi)
        edges = math.pi / 4
        shares[motion] = max(bell.cdf(edges - off) - bell.cdf(-edges - off), 1e-6)
    total = sum(shares.values())
    return {way: shares[way] / total for way in WAYS[Component.SLIDE]}
