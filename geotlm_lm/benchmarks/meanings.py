"""Whether two programs mean the same: what they come to on recordings that are made up."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.twist import COMPONENTS, WAYS, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import ContactArea, Evidence
from geotlm_lm.query.phrases import label_of
from geotlm_lm.query.program import Program, head_of, type_of
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Measure,
    Moved,
    Placed,
    Record,
    Recording,
    Remark,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.worlds import worlds_of_track
from geotlm_lm.track.events import COMPONENT_OF, Event, EventKind, Span
from geotlm_lm.track.summed import belief_of_track
from geotlm_lm.track.track import Track

RECORDINGS, STEP_S = 50, 0.04
HELD = 0.3
"""Share of recordings that end in contact."""

FRAMES = (FrameSpec(), FrameSpec(thread="right", contact_side="head", mm_per_px=0.08))
"""What is known of the set-up, in turn: nothing, and whatever an answer may lack."""

_LEGS = ("turn", "slide", "press", "release", "stick")


def come_to_the_same(one: Program, other: Program) -> bool:
    """Tell whether two programs state the same and come to the same on every made recording.

    Args:
        one: With its numbers and words, and what it leans on spelled out.
        other: Likewise.
    """
    if set(one.facts) != set(other.facts) or len(one.answers) != len(other.answers):
        return False
    return one.answers == other.answers or all(
        all(map(is_same, answers(one, clips, frame), answers(other, clips, frame)))
        for clips, frame in _made()
    )


def is_same(one: Value, other: Value) -> bool:
    """Tell whether two values say the same: amounts within their tolerance, times to a frame."""
    if type(one) is not type(other) or _asked(one) != _asked(other):
        return False
    match one:
        case Unknown():
            return one.reason == other.reason
        case Truth():
            return one.holds == other.holds
        case Amount():
            return one.amount.is_near(other.amount)
        case Times():
            times = one.times_s, other.times_s
            return len(times[0]) == len(times[1]) and np.allclose(*times, rtol=0, atol=STEP_S)
        case Moved():
            pairs = zip(one.movements, other.movements, strict=False)
            return _ways(one) == _ways(other) and all(
                _is_near(a.amount, b.amount) for a, b in pairs
            )
        case Choice():
            return _chosen(one) == _chosen(other)
        case Record():
            return [key for key, _ in one.fields] == [key for key, _ in other.fields] and all(
                is_same(a, b) for (_, a), (_, b) in zip(one.fields, other.fields, strict=True)
            )
        case Placed():
            return (one.across, one.down, one.share) == (other.across, other.down, other.share)
        case Remark():
            return (one.kind, one.topic) == (other.kind, other.topic)
    raise TypeError(f"no value: {one!r}")


def _asked(value: Value) -> tuple[str, str]:
    """Return the type of what is asked, and its word where another tells the same otherwise."""
    kind = type_of(value.of)
    return kind, head_of(value.of).word if kind in ("way", "talk") else ""


def _is_near(one: Measure | None, other: Measure | None) -> bool:
    return one is other if one is None or other is None else one.is_near(other)


def _ways(value: Moved) -> tuple[object, ...]:
    moves = [(move.way, move.aslant) for move in value.movements]
    happened = [(each.kind, each.way, each.begin_s, each.end_s) for each in value.shown]
    story = happened if head_of(value.of).word == "story" else []
    return moves, set(value.denied), value.still_axis, value.rest, value.tightens, story


def _chosen(value: Choice) -> set[str | int]:
    head = head_of(value.of)
    if head.word in ("choose", "choose-not"):
        return {label_of(head.arguments[0][place]) for place in value.chosen}
    return set(value.chosen)


@lru_cache(maxsize=1)
def _made() -> tuple[tuple[tuple[Evidence, Evidence], FrameSpec], ...]:
    """Return each recording behind the one before it, and what is known of its set-up."""
    made = [_evidence(place) for place in range(RECORDINGS)]
    pairs = zip([made[-1], *made], made, strict=False)
    return tuple((pair, FRAMES[place % len(FRAMES)]) for place, pair in enumerate(pairs))


def _evidence(seed: int) -> Evidence:
    rng = generator_for(seed, "meanings")
    track = made_track(rng)
    ways = dict.fromkeys((way for ways in WAYS.values() for way in ways), 0.0)
    readable = dict.fromkeys(COMPONENTS, True)
    belief = belief_of_track(track, Belief(Twist(), 0.1 * np.eye(4), ways, 1.0, 30.0, readable))
    rows, columns = track.frame_size
    recording = Recording(columns, rows, 1 / STEP_S, len(track), step_s=STEP_S)
    area = ContactArea(*rng.uniform(0.2, 0.8, 2), rng.uniform(0.05, 0.3))
    return Evidence(worlds_of_track(track, belief, seed), recording, area)


def made_track(rng: np.random.Generator) -> Track:
    """Return a recording of 25 frames a second, touched once or twice, with a few motions each."""
    events: list[Event] = []
    touched: list[tuple[int, int]] = []
    at = int(rng.integers(5, 25))
    for _ in range(int(rng.integers(1, 3))):
        begin = at
        events.append(_event(rng, "touch", at, at))
        for kind in rng.choice(_LEGS, int(rng.integers(1, 6))):
            length = int(rng.integers(8, 40))
            events.append(_event(rng, str(kind), at, at + length))
            at += length + int(rng.integers(0, 8))
        events.append(_event(rng, "release", at, at))
        touched.append((begin, at))
        at += int(rng.integers(10, 30))
    if rng.random() < HELD:
        at = events.pop().end
    count = at + 1
    twists, contact = np.zeros((count, 4)), np.full(count, 0.01)
    for begin, end in touched:
        contact[begin : end + (end == at)] = 0.99
    for event in events:
        steps = rng.uniform(0.2, 1.0, event.end - event.begin)
        way = event.twist
        far = np.array([way.turn_deg, way.right_px, way.down_px, way.inward_mm])
        twists[event.begin + 1 : event.end + 1] += np.outer(steps / max(steps.sum(), 1e-9), far)
    return Track(
        numbers=np.arange(count),
        times_s=np.arange(count) * STEP_S,
        contact=contact,
        strength_grey=5.0 * contact,
        twists=twists,
        covariances=np.tile(1e-4 * np.eye(4), (count, 1, 1)),
        radius_px=np.full(count, 50.0),
        turn_shares=np.full(count, 0.16),
        events=tuple(events),
        frame_size=(240, 320),
    )


def _event(rng: np.random.Generator, name: str, begin: int, end: int) -> Event:
    """Return a motion, a touch or a rest between two frames; its way and its length are drawn."""
    kind, sign = EventKind(name), rng.choice([-1, 1])
    angle, far = rng.integers(8) * np.pi / 4, rng.uniform(5, 40)
    twist, amount = {
        "turn": (Twist(turn_deg=sign * 2 * far), sign * 2 * far),
        "slide": (Twist(right_px=far * np.cos(angle), down_px=far * np.sin(angle)), far),
        "press": (Twist(inward_mm=far / 40), far / 40),
        "release": (Twist(inward_mm=-far / 40), -far / 40),
    }.get(name, (Twist(), 0.0))
    span, sure = Span(amount, 0.08 * abs(amount)), rng.uniform(0.7, 0.99)
    times_s = begin * STEP_S, end * STEP_S
    return Event(kind, begin, end, *times_s, twist, span, sure, COMPONENT_OF.get(kind))
