"""What a query asks of a whole recording: spans, times, counts and order of what happens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.twist import COMPONENT_OF
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Missing, Recording, component_of
from geotlm_lm.query.bounds import measured, meets_timed, timed_as
from geotlm_lm.query.happenings import (
    Happening,
    Limit,
    Sized,
    as_contact,
    by_begin,
    is_so,
    seen,
    turned_back,
)
from geotlm_lm.query.intervals import outside, within_all, within_any
from geotlm_lm.query.paths import crossing, played
from geotlm_lm.query.quantities import in_base
from geotlm_lm.track.events import TOGETHER_S, EventKind
from geotlm_lm.track.summed import belief_of_track
from geotlm_lm.track.track import Track, together_s

_NAMED = {
    "whole": (0.0, 1.0),
    "start": (0.0, 0.25),
    "end": (0.75, 1.0),
    "first-half": (0.0, 0.5),
    "second-half": (0.5, 1.0),
}
"""Shares of a recording's time that a name stands for."""


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
    except UsageError as error:
        raise Missing("span") from error
    return part, belief_of_track(part, belief)


def judged(
    said: t.Literal, found: Timed, track: Track, recording: Recording
) -> tuple[float, bool, bool]:
    """Return how probable a count or a duration is, whether a bound is met by it, and otherwise.

    What is told is likelier than not, and otherwise nothing of it happens; of what does not happen
    it is all the time, or once.

    Args:
        said: The bound.
        found: The count or duration that is told.
        track: Of the recording.
        recording: The file.

    Returns:
        A probability; whether the literal holds that probably, and whether it does otherwise.

    Raises:
        Missing: If it is said in seconds and no frame rate is known.
    """

    def in_base(end: t.Quantity) -> float:
        return _length_s(end, track, recording) if end.unit else end.value

    told = found.times[0]
    most = 1.0 if timed_as(said) == "how-often" else track.seconds
    so, otherwise = (meets_timed(said, one, in_base) for one in (told, 0.0 if told else most))
    sure = max(found.probability, _LIKELIER)
    return (sure, so, otherwise) if told else (1 - sure, otherwise, so)


_LIKELIER = 0.51
"""So that no verdict contradicts the count or duration that is told beside it."""


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


def on_track(ask: t.Ask, edit: Edit, track: Track | None, sized: Sized, limit: Limit) -> Timed:
    """Return what answers "when", "how long", "how often" and "in which order".

    Played backwards, times run from the end. What is said of an amount is so of the events that go
    that far; "when it had turned more than" is the moment at which the way from the start does.

    Args:
        ask: What is asked.
        edit: The point of view.
        track: Of the recording.
        sized: Tells how far an event goes.
        limit: Converts what is said.

    Raises:
        Missing: If no recording was followed, or it does not tell.
    """
    if track is None:
        raise Missing("track")
    found = seen(track, edit, sized)
    if ask.kind == "order":
        return _order(ask, found, track, limit)
    ask = replace(ask, proposition=as_contact(ask.proposition))
    if any(one.denied for one in ask.proposition.literals):
        return _denied(ask, found, played(track, edit), limit)
    atoms = _atoms(ask.proposition)
    if ask.kind == "how-often" and atoms == ["reverses"]:
        turns = tuple(one for one in found if one.kind is EventKind.TURN)
        count = float(len(turned_back(found, ask.proposition.literals[0], limit)))
        return Timed(None, turns, (count,), _sure(turns, track))
    bounded = [one for one in ask.proposition.literals if one.bound is not None]
    if atoms == ["touch"] and not bounded and ask.kind in ("when", "how-often"):
        return _contacts(ask, edit, track)
    is_passed = len(bounded) == 1 and bounded[0].bound.relation == "more"
    if ask.kind == "when" and is_passed and bounded[0].atom != "reverses":
        return _crossed(ask, bounded[0], found, played(track, edit), edit, limit)
    chosen = [one for one in found if is_so(one, ask.proposition, found, limit)]
    if ask.kind == "when" and atoms == ["none"] and not chosen:  # never touched, or never let go
        return _denied(replace(ask, proposition=_NOT_TOUCHED), found, played(track, edit), limit)
    if ask.kind == "how-often":
        return Timed(None, tuple(chosen), (float(len(chosen)),), _sure(chosen, track))
    if ask.kind == "how-long":
        return Timed(None, tuple(chosen), (_together(ask, chosen, track),), _sure(chosen, track))
    # That it stops is where its last motion ends.
    begins = ask.edge == "begin" and atoms != ["stops"]
    times = [one.begin_s for one in chosen][:1] if begins else [one.end_s for one in chosen][-1:]
    return Timed(None, tuple(chosen), tuple(times), _sure(chosen, track))


def _denied(ask: t.Ask, found: Sequence[Happening], track: Track, limit: Limit) -> Timed:
    """Return for which times something is so of which a part is denied: all but its own."""
    whole = (float(track.times_s[0]), float(track.times_s[-1]))
    spans = []
    for one in ask.proposition.literals:
        said = t.Proposition((replace(one, denied=False),))
        if one.atom in ("touch", "none"):
            own = list(track.contacts())
            own = own if one.atom == "touch" else outside(own, whole)
        else:
            own = [(each.begin_s, each.end_s) for each in found if is_so(each, said, found, limit)]
        spans.append(outside(own, whole) if one.denied else own)
    spans = (within_all if ask.proposition.joint == "and" else within_any)(spans)
    spans = [one for one in spans if one[1] > one[0]]
    if ask.kind == "when":
        times = spans[0] if spans and ask.edge == "begin" else tuple(end for _, end in spans[-1:])
    elif ask.kind == "how-long":
        times = (sum(end - begin for begin, end in spans),)
    else:
        times = (float(len(spans)),)
    return Timed(None, (), times, _sure(found, track))


def _crossed(
    ask: t.Ask, said: t.Literal, found: Sequence[Happening], track: Track, edit: Edit, limit: Limit
) -> Timed:
    """Return when a way, or a speed, first or last is more than what is said."""
    beyond = crossing(said, edit, track, limit)
    if not len(beyond):
        return Timed(None, (), (), _sure(found, track))
    at = float(beyond[0 if ask.edge == "begin" else -1])
    component = component_of(measured(said))
    during = [
        one
        for one in found
        if one.begin_s <= at <= one.end_s
        and one.kind is not EventKind.TOUCH
        and COMPONENT_OF.get(one.way) is component
    ]
    return Timed(None, tuple(during), (at,), _sure(during or found, track))


def _order(ask: t.Ask, found: Sequence[Happening], track: Track, limit: Limit) -> Timed:
    if ask.of is None:
        return Timed(None, tuple(found), (), _sure(found, track))
    firsts = []
    for atom in (ask.of, ask.then):
        if atom is not None:
            said = t.Proposition((t.Literal(atom),))
            firsts.append(next((one for one in found if is_so(one, said, found, limit)), None))
    if None in firsts:
        return Timed(False, tuple(one for one in firsts if one), (), _sure(found, track))
    if len(firsts) == 1:
        verdict = firsts[0].begin_s <= found[0].begin_s + TOGETHER_S
        return Timed(verdict, tuple(found), (), _sure(found, track))
    verdict = firsts[0].begin_s < firsts[1].begin_s
    return Timed(verdict, tuple(sorted(firsts, key=by_begin)), (), _sure(firsts, track))


def _contacts(ask: t.Ask, edit: Edit, track: Track) -> Timed:
    spans = played(track, edit).contacts()
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


_NOT_TOUCHED = t.Proposition((t.Literal("touch", denied=True),))


def _atoms(proposition: t.Proposition) -> list[str]:
    return [one.atom for one in proposition.literals]
