"""What a query asks of a whole recording: spans, times, counts and order of what happens."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geotlm_lm.core.labels import Motion, reverse
from geotlm_lm.core.twist import COMPONENT_OF, COMPONENTS, COUNTING_PX, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import OF_ATOM, Measure, Missing, Recording
from geotlm_lm.query.edit import Edit
from geotlm_lm.query.quantities import in_base
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.track import Track
from geotlm_lm.track.whole import belief_of_track, path_of_event, together_s

_NAMED = {
    "whole": (0.0, 1.0),
    "start": (0.0, 0.25),
    "end": (0.75, 1.0),
    "first-half": (0.0, 0.5),
    "second-half": (0.5, 1.0),
}
"""Shares of a recording's time that a name stands for."""

TOGETHER_S = 0.2
"""Events that begin or end no farther apart do so in the same moment."""

_BACKWARDS = {EventKind.PRESS: EventKind.RELEASE, EventKind.RELEASE: EventKind.PRESS}
TOLD = (*(EventKind.TOUCH, EventKind.PRESS, EventKind.TURN, EventKind.SLIDE),
        *(EventKind.STICK, EventKind.RELEASE))  # fmt: skip
"""Kinds of a story's events; a slip is a turn or a slide that is told already."""

Sized = Callable[[Event, str], Measure]
"""(event, atom) -> how far it goes, as it is told."""


@dataclass(frozen=True)
class Happening:
    """An event as it is told, from a point of view.

    Args:
        kind: What happens.
        way: Where it goes; of a touch a press, of a stick stillness.
        begin_s: When it begins.
        end_s: When it ends.
        amount: How far it goes; None of a touch or a stick.
        path_px: How far it moves the imprint.
        probability: That it happens.
    """

    kind: EventKind
    way: Motion
    begin_s: float
    end_s: float
    amount: Measure | None
    path_px: float
    probability: float


@dataclass(frozen=True)
class Timed:
    """What a recording answers by.

    Args:
        verdict: Of a yes-or-no question.
        happenings: That are told, in order.
        times: Seconds, or a count.
        probability: Of the least sure thing that is told.
    """

    verdict: bool | None = None
    happenings: tuple[Happening, ...] = ()
    times: tuple[float, ...] = ()
    probability: float = 1.0


def part_of(
    track: Track | None, belief: Belief, span: t.Span, recording: Recording
) -> tuple[Track, Belief]:
    """Return the track of a part of a recording and what is believed of its motion.

    Raises:
        Missing: If no recording was followed, a time has no frame rate, or the part no two frames.
    """
    if track is None:
        raise Missing("track")
    first_s, seconds = float(track.times_s[0]), track.seconds
    ends = [one for one in (span.begin, span.end) if one is not None]
    unit = next((one.unit for one in ends if one.unit), _unit_of(ends, track))
    span = t.Span(span.name, *(one and t.Quantity(one.value, one.unit or unit)
                               for one in (span.begin, span.end)))  # fmt: skip
    begin, end = (first_s + one * seconds for one in _NAMED[span.name or "whole"])
    if span.name == "end" and span.end is not None:  # "the last 0.5 seconds"
        begin, end = first_s + seconds - _length_s(span.end, track, recording), first_s + seconds
    elif span.name == "start" and span.end is not None:
        end = first_s + _length_s(span.end, track, recording)
    else:
        begin = begin if span.begin is None else _moment_s(span.begin, track, recording)
        end = end if span.end is None else _moment_s(span.end, track, recording)
    try:
        part = track.between(min(begin, end) - 1e-9, max(begin, end) + 1e-9, unit="s")
    except ValueError as error:
        raise Missing("span") from error
    return part, belief_of_track(part, belief)


def _unit_of(ends: Sequence[t.Quantity], track: Track) -> str:
    """Return the unit of times said without one: seconds, unless the recording is shorter."""
    is_whole = all(one.value == round(one.value) for one in ends)
    return "frame" if is_whole and any(one.value > track.times_s[-1] for one in ends) else "s"


def _moment_s(said: t.Quantity, track: Track, recording: Recording) -> float:
    value, unit, _ = in_base(said)
    if unit == "s":
        if not recording.rate_hz:
            raise Missing("rate")
        return value
    if unit != "frame":
        raise Missing("unit")
    return float(np.interp(value, track.numbers, track.times_s))


def _length_s(said: t.Quantity, track: Track, recording: Recording) -> float:
    value, unit, _ = in_base(said)
    if unit == "frame":
        return value * track.seconds / max(int(track.numbers[-1] - track.numbers[0]), 1)
    return _moment_s(said, track, recording)


def on_track(
    ask: t.Ask, edit: Edit, track: Track | None, sized: Sized, limit: Callable[..., float]
) -> Timed:
    """Return what answers "when", "how long", "how often" and "in which order".

    Played backwards, times run from the end.

    Args:
        ask: What is asked.
        edit: The point of view.
        track: Of the recording.
        sized: Tells how far an event goes.
        limit: (what is measured, what is said) -> the same in its base unit.

    Raises:
        Missing: If no recording was followed, or it does not tell.
    """
    if track is None:
        raise Missing("track")
    found = seen(track, edit, sized)
    if ask.kind == "order":
        return _order(ask, found, track)
    if ask.kind == "how-often" and _atoms(ask.proposition) == ["reverses"]:
        turns = [one for one in found if one.kind is EventKind.TURN]
        return Timed(None, tuple(turns), (float(len(turned_back(turns))),), _sure(turns, track))
    if _atoms(ask.proposition) == ["touch"] and ask.kind in ("when", "how-often"):
        return _contacts(ask, edit, track)
    chosen = [one for one in found if _is(one, ask.proposition, found)]
    if ask.kind == "when" and (crossed := _crossing(ask.proposition, edit, track, limit)):
        return Timed(None, tuple(chosen), crossed, _sure(chosen, track))
    if ask.kind == "how-often":
        return Timed(None, tuple(chosen), (float(len(chosen)),), _sure(chosen, track))
    if ask.kind == "how-long":
        return Timed(None, tuple(chosen), (_together(ask, chosen, track),), _sure(chosen, track))
    times = [one.begin_s if ask.edge == "begin" else one.end_s for one in chosen]
    times = times[:1] if ask.edge == "begin" else times[-1:]
    return Timed(None, tuple(chosen), tuple(times), _sure(chosen, track))


def happens(atom: str, edit: Edit, track: Track, sized: Sized) -> bool:
    """Tell whether something that only a recording shows happens in it."""
    found = seen(track, edit, sized)
    proposition = t.Proposition((t.Literal(atom),))
    return any(_is(one, proposition, found) for one in found)


def seen(track: Track, edit: Edit, sized: Sized) -> list[Happening]:
    """Return a recording's events from a point of view, by when they begin."""
    total = float(track.times_s[0] + track.times_s[-1])
    found = _touches(track, total) if edit.backwards else []
    for event in track.events:
        if event.kind not in TOLD or (edit.backwards and event.kind is EventKind.TOUCH):
            continue
        path = 0.0 if event.component is None else path_of_event(track, event)
        if event.component is not None and path < COUNTING_PX:  # a span cut off the rest
            continue
        begin, end, kind = event.begin_s, event.end_s, event.kind
        if edit.backwards:
            begin, end = total - end, total - begin
            kind = _BACKWARDS.get(kind, kind)
        way = edit.of_way(motion_of(event)) if event.component else motion_of(event)
        amount = None if event.component is None else sized(event, event.component.value)
        found.append(Happening(kind, way, begin, end, amount, path, event.probability))
    return sorted(found, key=_by_begin)


def _touches(track: Track, total: float) -> list[Happening]:
    """Return where contact begins when a recording is played backwards: where it ended."""
    ends = [total - end for _, end in track.contacts() if end < track.times_s[-1]]
    sure = float(track.contact.max(initial=0.0))
    return [Happening(EventKind.TOUCH, Motion.PRESS, at, at, None, 0.0, sure) for at in ends]


def motion_of(event: Event) -> Motion:
    """Return which of the ten words an event is, in the recorded image."""
    if event.kind is EventKind.TOUCH:
        return Motion.PRESS
    if event.kind is EventKind.STICK:
        return Motion.STILL
    return event.twist.way(event.component)


def turned_back(turns: Sequence[Happening]) -> list[Happening]:
    """Return the turns that go against the one before."""
    return [one for before, one in pairwise(turns) if one.way is reverse(before.way)]


def _by_begin(one: Happening) -> tuple:
    return (one.begin_s, one.kind is not EventKind.TOUCH, one.kind is EventKind.RELEASE)


def _order(ask: t.Ask, found: Sequence[Happening], track: Track) -> Timed:
    if ask.of is None:
        return Timed(None, tuple(found), (), _sure(found, track))
    firsts = []
    for atom in (ask.of, ask.then):
        if atom is not None:
            said = t.Proposition((t.Literal(atom),))
            firsts.append(next((one for one in found if _is(one, said, found)), None))
    if None in firsts:
        return Timed(False, tuple(one for one in firsts if one), (), _sure(found, track))
    if len(firsts) == 1:
        is_so = firsts[0].begin_s <= found[0].begin_s + TOGETHER_S
        return Timed(is_so, tuple(found), (), _sure(found, track))
    is_so = firsts[0].begin_s < firsts[1].begin_s
    return Timed(is_so, tuple(sorted(firsts, key=_by_begin)), (), _sure(firsts, track))


def _contacts(ask: t.Ask, edit: Edit, track: Track) -> Timed:
    spans = list(track.contacts())
    if edit.backwards:
        total = float(track.times_s[0] + track.times_s[-1])
        spans = [(total - end, total - begin) for begin, end in reversed(spans)]
    sure = float(track.contact.max(initial=0.0))
    sure = max(sure, 1 - sure)
    if ask.kind == "how-often":
        return Timed(None, (), (float(len(spans)),), sure)
    ends = spans[:1] if ask.edge == "begin" else spans[-1:]
    return Timed(None, (), tuple(one[ask.edge == "end"] for one in ends), sure)


def _together(ask: t.Ask, chosen: Sequence[Happening], track: Track) -> float:
    atoms = _atoms(ask.proposition)
    touched = sum(end - begin for begin, end in track.contacts())
    if atoms in (["touch"], ["made"]):
        return touched
    if atoms in (["none"], ["lost"]):
        return track.seconds - touched
    return together_s(chosen)


def _sure(chosen: Sequence[Happening], track: Track) -> float:
    touched = float(track.contact.max(initial=0.0))
    return min((one.probability for one in chosen), default=max(touched, 1 - touched))


def _atoms(proposition: t.Proposition) -> list[str]:
    return [one.atom for one in proposition.literals]


def _crossing(
    proposition: t.Proposition, edit: Edit, track: Track, limit: Callable[..., float]
) -> tuple[float, ...]:
    """Return when a way first goes beyond what is said: "when had it turned more than 20 deg"."""
    bounded = [one for one in proposition.literals if one.bound is not None]
    if len(bounded) != 1 or edit.backwards:
        return ()
    atom = "turn" if bounded[0].atom == "move" else bounded[0].atom
    if atom not in OF_ATOM:
        raise Missing("unit")
    name, sign = OF_ATOM[atom]
    least = limit(name, bounded[0].bound.low)
    way = track.path_from_start @ edit.matrix.T
    place = {"turn": 0, "x": 1, "y": 2, "inward": 3}
    far = np.hypot(way[:, 1], way[:, 2]) if name == "slide" else way[:, place[name]]
    far = far * sign if sign else np.abs(far)
    beyond = np.flatnonzero(far >= least)
    return (float(track.times_s[beyond[0]]),) if len(beyond) else ()


def _is(one: Happening, proposition: t.Proposition, found: Sequence[Happening]) -> bool:
    held = [_has(one, each.atom, found) != each.denied for each in proposition.literals]
    return all(held) if proposition.joint == "and" else any(held)


def _has(one: Happening, atom: str, found: Sequence[Happening]) -> bool:
    moves = one.kind in (EventKind.TURN, EventKind.SLIDE)
    if atom in t.WAY_ATOMS:
        return one.kind is not EventKind.TOUCH and one.way is t.WAY_ATOMS[atom]
    if atom in t.COMPONENT_ATOMS:
        component = COMPONENT_OF.get(one.way) if one.kind is not EventKind.TOUCH else None
        return component is t.COMPONENT_ATOMS[atom] and one.kind is not EventKind.RELEASE
    if atom == "reverses":
        return one in turned_back(
            [each for each in found if each.kind is one.kind is EventKind.TURN]
        )
    if atom in ("speeds", "slows", *t.THREAD_ATOMS):
        raise Missing("speeds")
    return {
        "move": moves,
        "starts": moves,
        "stops": moves,
        "still": one.kind is EventKind.STICK,
        "none": one.kind is EventKind.RELEASE,
        "lost": one.kind is EventKind.RELEASE,
        "touch": one.kind is EventKind.TOUCH,
        "made": one.kind is EventKind.TOUCH,
        "x": moves and one.way in (Motion.LEFT, Motion.RIGHT),
        "y": moves and one.way in (Motion.UP, Motion.DOWN),
    }[atom]


def peak(
    track: Track | None, component: Component, *, is_speed: bool
) -> tuple[float, float, float]:
    """Return the greatest way from the start, or the greatest speed, and its deviation and time.

    In degrees, pixels or mm, or the same per second; of either sign.

    Raises:
        Missing: If no recording was followed.
    """
    if track is None:
        raise Missing("track")
    if is_speed:
        time_s, speed = track.fastest(component)
        net = track.path(component)
        share = net.deviation / max(net.mean, 1e-6)
        return abs(speed), abs(speed) * min(share, 1.0), time_s
    column = COMPONENTS.index(component)
    way, doubt = track.path_from_start, track.path_deviations
    if component is Component.SLIDE:
        far, off = np.hypot(way[:, 1], way[:, 2]), np.max(doubt[:, 1:3], axis=1)
    else:
        far, off = np.abs(way[:, 3 * (column == 2)]), doubt[:, 3 * (column == 2)]
    place = int(np.argmax(far))
    return float(far[place]), float(off[place]), float(track.times_s[place])
