"""Tracks and beliefs: what a track comes to as a whole, and a clip of few frames as a track.

The belief of a track is that of its motion from the first frame to the last. The track of a clip of
two to four frames says what is believed of the clip as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import astuple, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, WAYS, Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.track.block import Row
from geotlm_lm.track.events import COLUMNS, STEPS, STICK_S, UNSURE_SHARE, Event, EventKind, Span
from geotlm_lm.track.track import STEPS_OF, Track, decided

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


Floats = NDArray[np.float64]

Whole = Callable[[Clip], Belief]
"""A clip of two to four frames, to what its questions are answered by."""

KINDS = {
    Motion.CLOCKWISE: EventKind.TURN,
    Motion.COUNTERCLOCKWISE: EventKind.TURN,
    Motion.PRESS: EventKind.PRESS,
    Motion.RELEASE: EventKind.RELEASE,
}
"""Of all other ways it is a slide."""


Shown = tuple[Row, Frames]
"""A frame of a clip, as it was measured, and its picture."""


def track_of_clip(shown: Sequence[Shown], belief: Belief, notes: tuple[str, ...] = ()) -> Track:
    """Return the track of two to four frames, given what is believed of their motion.

    What moves by the belief is an event from the first frame to the last, spread over the steps as
    these were measured.
    """
    rows, count = [row for row, _ in shown], len(shown)
    events = _events(rows, belief)
    twists, covariances = np.zeros((count, 4)), np.zeros((count, 4, 4))
    for event in events:
        if event.component is not None:
            part = COLUMNS[event.component]
            twists[:, part] = np.outer(_step_shares(rows, part), astuple(event.twist)[part])
    for place, component in enumerate(COMPONENTS):
        part = COLUMNS[component]
        covariances[1:, part, part] = belief.covariance[part, part] / STEPS[place] ** 2
    covariances[1:] /= count - 1
    touched = max(belief.contact, *map(belief.moves, COMPONENTS))
    track = Track(
        numbers=np.array([row.number for row in rows], np.int64),
        times_s=np.array([row.time_s for row in rows]),
        contact=np.full(count, touched),
        strength_grey=np.array([row.strength_grey for row in rows]),
        twists=twists,
        covariances=covariances,
        radius_px=np.full(count, belief.radius_px if touched >= 0.5 else 0.0),
        turn_shares=np.full(count, UNSURE_SHARE),
        events=(),
        frame_size=shown[0][1].shape[:2],
        notes=notes,
        is_contact_known=belief.is_contact_known,
        stated_limits=dict(belief.limits) or None,
    )
    return decided(track, events, {})


def _events(rows: Sequence[Row], belief: Belief) -> list[Event]:
    first, last = rows[0], rows[-1]
    sure = max(belief.contact, *map(belief.moves, COMPONENTS))
    if sure < 0.5:
        return []
    still = Twist()
    touch = Event(EventKind.TOUCH, first.number, first.number, first.time_s, first.time_s, still,
                  Span(0.0, 0.0), sure)  # fmt: skip
    whole = replace(touch, end=last.number, end_s=last.time_s)
    moving = [
        replace(
            whole,
            kind=KINDS.get(belief.way(component), EventKind.SLIDE),
            twist=_twist(belief, component),
            amount=_amount(belief, component),
            probability=belief.moves(component),
            component=component,
            is_readable=belief.readable.get(component, True),
        )
        for component in COMPONENTS
        if belief.moves(component) >= 0.5
    ]
    is_held = not {Component.TURN, Component.SLIDE} & {event.component for event in moving}
    if is_held and last.time_s - first.time_s >= STICK_S:
        moving.append(replace(whole, kind=EventKind.STICK))
    return [touch, *moving]


def _amount(belief: Belief, component: Component) -> Span:
    sign = -1.0 if belief.way(component) in (Motion.COUNTERCLOCKWISE, Motion.RELEASE) else 1.0
    return Span(sign * float(belief.amount(component)), float(belief.deviation(component)))


def _twist(belief: Belief, component: Component) -> Twist:
    """Return the believed motion of one component, along the way that is told of it."""
    mean, way = belief.mean, belief.way(component)
    if component is Component.TURN:
        return Twist(turn_deg=_amount(belief, component).mean)
    if component is Component.PRESS:
        return Twist(inward_mm=_amount(belief, component).mean)
    if mean.way(component) is way:
        return Twist(right_px=mean.right_px, down_px=mean.down_px)
    along = {Motion.RIGHT: (1, 0), Motion.LEFT: (-1, 0), Motion.DOWN: (0, 1), Motion.UP: (0, -1)}
    right, down = along[way]
    return Twist(right_px=right * mean.slide_px, down_px=down * mean.slide_px)


def _step_shares(rows: Sequence[Row], part: slice) -> Floats:
    """Return the share of each step in the way; even where nothing was measured."""
    if part == COLUMNS[Component.PRESS]:
        lengths = np.abs(np.diff([row.strength_grey for row in rows]))
    else:
        steps = [row.step for row in rows[1:]]
        lengths = np.array(
            [0.0 if step is None else np.linalg.norm(step.twist[part]) for step in steps]
        )
    total = lengths.sum()
    shares = lengths / total if total > 0 else np.full(len(lengths), 1 / len(lengths))
    return np.concatenate([[0.0], shares])
