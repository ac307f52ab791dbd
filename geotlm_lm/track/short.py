"""A clip of two to four frames as a track: it says what is believed of the clip as a whole."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.track.block import Row
from geotlm_lm.track.events import COLUMNS, STEPS, STICK_S, UNSURE_SHARE, Event, EventKind, Span
from geotlm_lm.track.track import Track, decided

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


@dataclass(frozen=True, eq=False)
class Shown:
    """A frame of a clip, as it was measured."""

    row: Row
    frame: Frames


def track_of_clip(shown: Sequence[Shown], belief: Belief, notes: tuple[str, ...] = ()) -> Track:
    """Return the track of two to four frames, given what is believed of their motion.

    What moves by the belief is an event from the first frame to the last, spread over the steps as
    these were measured.
    """
    rows, count = [frame.row for frame in shown], len(shown)
    events = _events(rows, belief)
    twists, covariances = np.zeros((count, 4)), np.zeros((count, 4, 4))
    for event in events:
        if event.component is not None:
            part = COLUMNS[event.component]
            twists[:, part] = np.outer(_shares(rows, part), astuple(event.twist)[part])
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
        frame_size=shown[0].frame.shape[:2],
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


def _shares(rows: Sequence[Row], part: slice) -> Floats:
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
