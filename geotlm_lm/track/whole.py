"""What a whole track comes to: one Belief of its motion, and the four frames that show it best."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import NormalDist

import numpy as np

from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, COUNTING_PX, WAYS, Component
from geotlm_lm.motion.belief import PX_PER_MM, Belief
from geotlm_lm.track.amounts import ENDS, SYSTEMATIC, Span
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.track import Track

WINDOW_DEG, WINDOW_PX = 30.0, 30.0
"""Most that turns or slides within four frames that are looked at together."""

CLOCKWISE = {1: Motion.CLOCKWISE, -1: Motion.COUNTERCLOCKWISE}
INWARD = {1: Motion.PRESS, -1: Motion.RELEASE}


def belief_of_track(track: Track, window: Belief) -> Belief:
    """Return what is believed of the motion from a track's first frame to its last.

    Args:
        track: Of a recording, or of a span of it.
        window: What is believed of the four frames that `window_of` tells; the language model
            reads of these.
    """
    mean, contact = track.net_twist, float(track.contact.max(initial=0.0))
    radii = track.radius_px[track.radius_px > 0]
    radius = float(np.median(radii)) if len(radii) else window.radius_px
    own = track.covariances.sum(axis=0)
    shares = np.array([SYSTEMATIC[0], *[SYSTEMATIC[1]] * 2, SYSTEMATIC[2]])
    ends = np.array([ENDS[0], *[ENDS[1]] * 2, ENDS[2]])
    doubt = np.square(shares * track.twists.sum(axis=0)) + np.square(ends)
    ways: dict[Motion, float] = {}
    for component in COMPONENTS:
        counts = contact * _counts(track, component, radius)
        ways |= {way: share * counts for way, share in _shares(track, component).items()}
    return replace(
        window,
        mean=mean,
        covariance=own + np.diag(doubt),
        ways=ways,
        contact=contact,
        radius_px=radius,
    )


def window_of(track: Track) -> tuple[int, ...]:
    """Return the places in a track of four frames that show its motion best.

    They lie evenly in its largest turn or slide, no farther apart than can be looked at together;
    where there is none in a press, else in what is touched.
    """
    places = np.flatnonzero(track.is_touched)
    main = main_event(track)
    if main is not None:
        first, last = np.searchsorted(track.numbers, [main.begin, main.end])
        first, last = _shortened(track, int(first), int(last))
    elif len(places):
        first, last = int(places[0]), int(places[-1])
    else:
        first, last = 0, len(track) - 1
    if last - first < 1:
        first, last = max(first - 1, 0), min(last + 1, len(track) - 1)
    return tuple(int(round(one)) for one in np.linspace(first, last, FRAME_COUNT))


def main_event(track: Track) -> Event | None:
    """Return the turn or slide that moves the imprint farthest; without one the longest press."""
    return max(
        (one for one in track.events if one.kind in _MAIN),
        key=lambda one: (
            one.kind not in (EventKind.PRESS, EventKind.RELEASE),
            path_of_event(track, one),
        ),
        default=None,
    )


_MAIN = (EventKind.TURN, EventKind.SLIDE, EventKind.PRESS, EventKind.RELEASE)


def together_s(events: Sequence[Event]) -> float:
    """Return the time in which at least one of some events goes on."""
    total, until = 0.0, -math.inf
    for one in sorted(events, key=lambda one: one.begin_s):
        total += max(one.end_s - max(one.begin_s, until), 0.0)
        until = max(until, one.end_s)
    return total


def path_of_event(track: Track, event: Event) -> float:
    """Return how far a turn, slide or press moves the imprint, pixels."""
    far = abs(event.amount.mean)
    if event.component is Component.TURN:
        place = int(np.searchsorted(track.numbers, event.end))
        return math.radians(far) * float(track.radius_px[place])
    return far * PX_PER_MM if event.component is Component.PRESS else far


def _shortened(track: Track, first: int, last: int) -> tuple[int, int]:
    """Return the middle part of a span in which no more moves than is looked at together."""
    way = np.cumsum(track.twists[first : last + 1], axis=0)
    turned = np.abs(way[:, 0] - way[0, 0]) / WINDOW_DEG
    slid = np.linalg.norm(way[:, 1:3] - way[0, 1:3], axis=1) / WINDOW_PX
    share = 1 / max(float(turned.max()), float(slid.max()), 1.0)
    middle, half = (first + last) / 2, share * (last - first) / 2
    return max(math.floor(middle - half), first), min(math.ceil(middle + half), last)


def _counts(track: Track, component: Component, radius_px: float) -> float:
    """Return how probable it is that a component counts in a track that is touched."""
    events = [one for one in track.of(component) if one.component is component]
    if component is Component.PRESS:
        # What begins or ends contact is told as that.
        events = [one for one in events if not _is_edge(track, one)]
    if events:
        return max(one.probability for one in events)
    if component is Component.PRESS:
        return 0.0
    net = track.net(component)
    least = math.degrees(COUNTING_PX / max(radius_px, 1.0))
    bound = least if component is Component.TURN else COUNTING_PX
    bell = NormalDist(abs(net.mean), max(net.deviation, 1e-6))
    return min(1 - bell.cdf(bound), 0.5)


def _is_edge(track: Track, event: Event) -> bool:
    """Tell whether a press or release is the beginning or the end of a contact."""
    begins = [one.begin for one in track.events if one.kind is EventKind.TOUCH]
    if event.kind is EventKind.PRESS:
        return any(0 <= event.begin - begin <= EDGE_FRAMES for begin in begins)
    place = int(np.searchsorted(track.numbers, event.end))
    after = track.contact[place : place + EDGE_FRAMES + 1]
    return bool((after < 0.5).any())


EDGE_FRAMES = 3


def _shares(track: Track, component: Component) -> dict[Motion, float]:
    """Return the probability of each way of a component, given that it counts."""
    twist, own = track.twists.sum(axis=0), track.covariances.sum(axis=0)
    if component is Component.SLIDE:
        return _quarters(twist[1:3], math.sqrt(float(np.trace(own[1:3, 1:3])) / 2 + ENDS[1] ** 2))
    net: Span = track.net(component)
    events = track.of(component)
    mean = net.mean
    if component is Component.PRESS and events:
        largest = max(events, key=lambda one: abs(one.amount.mean))
        mean = largest.amount.mean
    sure = NormalDist().cdf(mean / max(net.deviation, 1e-6))
    named = CLOCKWISE if component is Component.TURN else INWARD
    return {named[1]: sure, named[-1]: 1 - sure}


def _quarters(way: np.ndarray, deviation: float) -> dict[Motion, float]:
    """Return how probable it is that a travel lies in each quarter of the image."""
    spread = max(math.atan2(deviation, float(np.hypot(*way))), 0.02)
    angle = math.atan2(way[1], way[0])
    bell, found = NormalDist(0.0, spread), {}
    for place, motion in enumerate((Motion.RIGHT, Motion.DOWN, Motion.LEFT, Motion.UP)):
        off = math.remainder(angle - place * math.pi / 2, 2 * math.pi)
        edges = math.pi / 4
        found[motion] = max(bell.cdf(edges - off) - bell.cdf(-edges - off), 1e-6)
    total = sum(found.values())
    return {way: found[way] / total for way in WAYS[Component.SLIDE]}
