"""What happens in a recording, seen from a point of view, and of what a proposition is so."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from geotlm_lm.core.edit import Edit, opposite
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, Twist
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure, Missing
from geotlm_lm.query.bounds import measured, meets
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.track import Track, path_of_event

_BACKWARDS = {EventKind.PRESS: EventKind.RELEASE, EventKind.RELEASE: EventKind.PRESS}
TOLD = (*(EventKind.TOUCH, EventKind.PRESS, EventKind.TURN, EventKind.SLIDE),
        *(EventKind.STICK, EventKind.RELEASE))  # fmt: skip
"""Kinds of a story's events; a slip is a turn or a slide that is told already."""

Sized = Callable[[Event, str], Measure]
"""(event, atom) -> how far it goes, as it is told."""

Limit = Callable[[str, Quantity, float], float]
"""(what is measured, what is said, seconds that it takes) -> the same in its base unit."""

_REVERSES = t.Literal("reverses")


@dataclass(frozen=True)
class Happening:
    """An event as it is told, from a point of view.

    Args:
        kind: What happens.
        way: Where it goes; of a touch a press, of a stick stillness.
        begin_s: When it begins.
        end_s: When it ends.
        twist: How far it goes and which way.
        amount: How far it goes, as it is told; None of a touch or a stick.
        path_px: How far it moves the imprint.
        probability: That it happens.
    """

    kind: EventKind
    way: Motion
    begin_s: float
    end_s: float
    twist: Twist
    amount: Measure | None
    path_px: float
    probability: float


def seen(track: Track, edit: Edit, sized: Sized) -> list[Happening]:
    """Return a recording's events from a point of view, by when they begin."""
    total = float(track.times_s[0] + track.times_s[-1])
    found = _touches(track, total) if edit.backwards else []
    for event in track.events:
        if event.kind not in TOLD or (edit.backwards and event.kind is EventKind.TOUCH):
            continue
        if event.amount.mean and not event.amount.is_clear:  # a span cut off the rest
            continue
        path = 0.0 if event.component is None else path_of_event(track, event)
        begin, end, kind = event.begin_s, event.end_s, event.kind
        if edit.backwards:
            begin, end = total - end, total - begin
            kind = _BACKWARDS.get(kind, kind)
        way = edit.of_way(event.motion) if event.component else event.motion
        amount = None if event.component is None else sized(event, event.component.value)
        twist = edit.of_twist(event.twist)
        found.append(Happening(kind, way, begin, end, twist, amount, path, event.probability))
    return sorted(found, key=by_begin)


def _touches(track: Track, total: float) -> list[Happening]:
    """Return where contact begins when a recording is played backwards: where it ended."""
    ends = [total - end for _, end in track.contacts() if end < track.times_s[-1]]
    sure = float(track.contact.max(initial=0.0))
    rest = Twist(0.0, 0.0, 0.0, 0.0)
    return [Happening(EventKind.TOUCH, Motion.PRESS, at, at, rest, None, 0.0, sure) for at in ends]


def turned_back(
    found: Sequence[Happening], said: t.Literal = _REVERSES, limit: Limit | None = None
) -> list[tuple[Happening, Happening]]:
    """Return the turns that go against the one before, and as far as is said, behind that one."""
    turns = [one for one in found if one.kind is EventKind.TURN]
    return [
        (before, one)
        for before, one in pairwise(turns)
        if one.way is opposite(before.way) and (said.bound is None or _goes(one, said, limit))
    ]


def happens(said: t.Literal, edit: Edit, track: Track, sized: Sized, limit: Limit) -> float:
    """Return how probable it is that something that only a recording shows happens in it.

    That of the surest event that shows it; of none the doubt in what was found instead.

    Raises:
        Missing: If it is bounded and has no amount, or a track does not show it.
    """
    if said.bound is not None:
        measured(said)
    found = seen(track, edit, sized)
    proposition = t.Proposition((replace(said, denied=False),))
    if said.atom == "reverses":
        pairs = turned_back(found, said, limit)
        shown = [min(before.probability, one.probability) for before, one in pairs]
    else:
        shown = [one.probability for one in found if is_so(one, proposition, found, limit)]
    if shown:
        return max(shown)
    touched = float(track.contact.max(initial=0.0))
    return 1 - max((one.probability for one in found), default=max(touched, 1 - touched))


def is_so(
    one: Happening,
    proposition: t.Proposition,
    found: Sequence[Happening],
    limit: Limit | None = None,
) -> bool:
    """Tell whether a proposition is so of one of a recording's events, amounts it bounds included.

    Raises:
        Missing: If it bounds what has no amount, or in a unit that nobody can convert.
    """
    held = [
        (_has(one, each.atom, found) and (each.bound is None or _goes(one, each, limit)))
        != each.denied
        for each in proposition.literals
    ]
    return all(held) if proposition.joint == "and" else any(held)


_CONTRARY = {"touch": "none", "none": "touch", "made": "lost", "lost": "made"}


def as_contact(proposition: t.Proposition) -> t.Proposition:
    """Return a proposition of one thing with denied contact as its absence, and the reverse."""
    first, *others = proposition.literals
    if others or not first.denied or first.atom not in _CONTRARY:
        return proposition
    return t.Proposition((t.Literal(_CONTRARY[first.atom], first.bound),))


def _goes(one: Happening, said: t.Literal, limit: Limit) -> bool:
    """Tell whether an event goes as far, or as fast, as a literal says."""
    name, twist = measured(said), one.twist
    lasts_s = max(one.end_s - one.begin_s, 1e-9)
    amount = {"turn": twist.turn_deg, "x": twist.right_px, "y": twist.down_px,
              "slide": twist.slide_px, "inward": twist.inward_mm}[name]  # fmt: skip
    return meets(said, amount, lambda end: limit(name, end, lasts_s))


def by_begin(one: Happening) -> tuple[float, bool, bool]:
    """Return what events are sorted by: of one moment a touch is the first, a release the last."""
    return (one.begin_s, one.kind is not EventKind.TOUCH, one.kind is EventKind.RELEASE)


def _has(one: Happening, atom: str, found: Sequence[Happening]) -> bool:
    moves = one.kind in (EventKind.TURN, EventKind.SLIDE)
    if atom in t.WAY_ATOMS:
        return one.kind is not EventKind.TOUCH and one.way is t.WAY_ATOMS[atom]
    if atom in t.COMPONENT_ATOMS:
        component = COMPONENT_OF.get(one.way) if one.kind is not EventKind.TOUCH else None
        return component is t.COMPONENT_ATOMS[atom] and one.kind is not EventKind.RELEASE
    if atom == "reverses":
        return any(one is back for _, back in turned_back(found))
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
