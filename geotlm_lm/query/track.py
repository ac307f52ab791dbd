"""What a query asks of a whole recording: spans, times, counts and order of its events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Missing, Recording
from geotlm_lm.query.edit import Edit
from geotlm_lm.query.quantities import in_base

_NAMED = {
    "whole": (0.0, 1.0),
    "start": (0.0, 0.25),
    "end": (0.75, 1.0),
    "first-half": (0.0, 0.5),
    "second-half": (0.5, 1.0),
}
"""Shares of a recording's time that a name stands for."""


@dataclass(frozen=True)
class Event:
    """A stretch of one motion, named in the recorded image; "still" of holding, "none" of absence.

    Args:
        way: What goes on.
        begin_s: When it begins.
        end_s: When it ends.
    """

    way: Motion
    begin_s: float
    end_s: float


class Track(Protocol):
    """A recording's motion over time."""

    @property
    def seconds(self) -> float:
        """How long it is."""

    def belief(self, begin_s: float, end_s: float) -> Belief:
        """Return what is believed of the motion between two times."""

    def events(self) -> Sequence[Event]:
        """Return what happens, in order; events of different components may overlap."""


def part_of(track: Track | None, span: t.Span, recording: Recording) -> Belief:
    """Return what is believed of a part of a recording.

    Raises:
        Missing: If no recording was followed, or a time has no frame rate.
    """
    if track is None:
        raise Missing("track")
    begin, end = _NAMED.get(span.name or "whole", (0.0, 1.0))
    times = [begin * track.seconds, end * track.seconds]
    for at, said in enumerate((span.begin, span.end)):
        if said is not None:
            times[at] = _seconds(said, recording)
    if span.name == "end" and span.end is not None:  # "the last 0.5 seconds"
        times = [track.seconds - _seconds(span.end, recording), track.seconds]
    low, high = (min(max(one, 0.0), track.seconds) for one in times)
    if low >= high:
        raise Missing("span")
    return track.belief(low, high)


def _seconds(said: t.Quantity, recording: Recording) -> float:
    value, unit, _ = in_base(said)
    if unit == "s":
        return value
    if unit not in ("", "frame"):
        raise Missing("unit")
    if not recording.rate_hz:
        raise Missing("rate")
    return value / recording.rate_hz


def on_track(ask: t.Ask, edit: Edit, track: Track | None) -> tuple[bool | None, tuple[float, ...]]:
    """Return a verdict, if one is asked for, and the times or counts that answer an ask.

    Of "when" the times, of "how-long" the seconds altogether, of "how-often" the count; of "order"
    the begin of each of the two, or of all events. Played backwards, times run from the end.

    Raises:
        Missing: If no recording was followed.
    """
    if track is None:
        raise Missing("track")
    events = sorted(_seen(edit, track), key=lambda one: one.begin_s)
    if ask.kind == "order":
        if ask.of is None:
            return None, tuple(one.begin_s for one in events)
        firsts = [_first(events, atom) for atom in (ask.of, ask.then) if atom is not None]
        if None in firsts:
            return False, ()
        return (len(firsts) < 2 or firsts[0] < firsts[1]), tuple(firsts)
    found = [one for one in events if _is(one, ask.proposition)]
    if ask.kind == "how-often":
        return None, (float(len(found)),)
    if ask.kind == "how-long":
        return None, (sum(one.end_s - one.begin_s for one in found),)
    begins = ask.edge == "begin"
    return None, tuple(one.begin_s if begins else one.end_s for one in found)


def _seen(edit: Edit, track: Track) -> list[Event]:
    way, total = edit.of_way, track.seconds
    if not edit.backwards:
        return [Event(way(one.way), one.begin_s, one.end_s) for one in track.events()]
    return [Event(way(e.way), total - e.end_s, total - e.begin_s) for e in track.events()]


def _first(events: Sequence[Event], atom: str) -> float | None:
    proposition = t.Proposition((t.Literal(atom),))
    return next((one.begin_s for one in events if _is(one, proposition)), None)


def _is(event: Event, proposition: t.Proposition) -> bool:
    found = [_has(event, one.atom) != one.denied for one in proposition.literals]
    return all(found) if proposition.joint == "and" else any(found)


def _has(event: Event, atom: str) -> bool:
    way = event.way
    if atom in t.WAY_ATOMS:
        return way is t.WAY_ATOMS[atom]
    if atom in t.COMPONENT_ATOMS:
        return COMPONENT_OF.get(way) is t.COMPONENT_ATOMS[atom]
    moving = way in COMPONENT_OF
    return {
        "move": moving,
        "starts": moving,
        "still": way is Motion.STILL,
        "stops": way is Motion.STILL,
        "none": way is Motion.NONE,
        "lost": way is Motion.NONE,
        "touch": way is not Motion.NONE,
        "made": way is not Motion.NONE,
        "x": way in (Motion.LEFT, Motion.RIGHT),
        "y": way in (Motion.UP, Motion.DOWN),
    }.get(atom, False)
