"""What a query asks of a whole recording: spans, times, counts and order of what happens."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import OF_ATOM, Missing, Recording
from geotlm_lm.query.edit import Edit
from geotlm_lm.query.happenings import Happening, Sized, by_begin, is_so, seen, turned_back
from geotlm_lm.query.quantities import in_base
from geotlm_lm.track.events import TOGETHER_S, EventKind
from geotlm_lm.track.track import Track
from geotlm_lm.track.whole import belief_of_track, together_s

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
    chosen = [one for one in found if is_so(one, ask.proposition, found)]
    if ask.kind == "when" and (crossed := _crossing(ask.proposition, edit, track, limit)):
        return Timed(None, tuple(chosen), crossed, _sure(chosen, track))
    if ask.kind == "how-often":
        return Timed(None, tuple(chosen), (float(len(chosen)),), _sure(chosen, track))
    if ask.kind == "how-long":
        return Timed(None, tuple(chosen), (_together(ask, chosen, track),), _sure(chosen, track))
    # That it stops is where its last motion ends.
    begins = ask.edge == "begin" and _atoms(ask.proposition) != ["stops"]
    times = [one.begin_s for one in chosen][:1] if begins else [one.end_s for one in chosen][-1:]
    return Timed(None, tuple(chosen), tuple(times), _sure(chosen, track))


def _order(ask: t.Ask, found: Sequence[Happening], track: Track) -> Timed:
    if ask.of is None:
        return Timed(None, tuple(found), (), _sure(found, track))
    firsts = []
    for atom in (ask.of, ask.then):
        if atom is not None:
            said = t.Proposition((t.Literal(atom),))
            firsts.append(next((one for one in found if is_so(one, said, found)), None))
    if None in firsts:
        return Timed(False, tuple(one for one in firsts if one), (), _sure(found, track))
    if len(firsts) == 1:
        verdict = firsts[0].begin_s <= found[0].begin_s + TOGETHER_S
        return Timed(verdict, tuple(found), (), _sure(found, track))
    verdict = firsts[0].begin_s < firsts[1].begin_s
    return Timed(verdict, tuple(sorted(firsts, key=by_begin)), (), _sure(firsts, track))


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
