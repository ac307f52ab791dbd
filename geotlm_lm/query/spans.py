"""Moments, spans of time and what happens in a recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from geotlm_lm.core.twist import ASLANT
from geotlm_lm.query import program as p
from geotlm_lm.query.arithmetic import converted
from geotlm_lm.query.contact_ends import require_over, unseen_ends
from geotlm_lm.query.evaluate import (
    PRIMITIVES,
    Context,
    Events,
    Floats,
    Numbers,
    Spot,
    Untold,
    contact_unknown,
    evaluate,
    grid,
    middle,
    moments,
)
from geotlm_lm.query.program import AXIS, COMPONENT, WAYS, Expression
from geotlm_lm.query.worlds import COUNT, Bools, Happening, Worlds, gaps, instant
from geotlm_lm.track.events import TOGETHER_S, EventKind


def _moment(context: Context, inner: Expression) -> Floats:
    """Return a time that is stated: seconds, a frame's number, or a share of the recording."""
    worlds = context.timed()
    stated = evaluate(inner, context)
    if stated.unit == "percent":
        return worlds.begin_s + stated.values / 100 * (worlds.end_s - worlds.begin_s)
    unit = stated.unit
    if not unit:
        is_frame = stated.values.max() > worlds.end_s and (stated.values % 1 == 0).all()
        unit = "frame" if is_frame else "s"
    if unit == "frame":
        numbers, times = worlds.track.numbers, worlds.track.times_s
        if context.view.backwards:
            times = (worlds.begin_s + worlds.end_s - times)[::-1]
        return np.interp(stated.values, numbers, times)
    if context.clock_unit != "s":
        raise Untold("rate")
    return converted(context, replace(stated, unit=unit), "s").values


def _stated_time(context: Context, inner: Expression, whole: Floats) -> Floats:
    """Return a stated time span on the recording's clock; a share is one of `whole`."""
    stated = evaluate(inner, context)
    if stated.unit == "percent":
        return stated.values / 100 * whole
    if stated.unit == "frame":
        track = context.timed().track
        steps = max(int(track.numbers[-1] - track.numbers[0]), 1)
        return stated.values * track.seconds / steps
    if context.clock_unit != "s":
        raise Untold("rate")
    return converted(context, stated, "s").values if stated.unit else stated.values


def _edge(name: str):
    def edge(context: Context, span: Expression) -> Floats:
        context.timed()
        times = getattr(evaluate(span, context), name)
        return np.broadcast_to(times, (COUNT,))

    return edge


def _shifted(sign: int):
    def shifted(context: Context, time: Expression, by: Expression) -> Floats:
        at = evaluate(time, context)
        return at + sign * _stated_time(context, by, Spot(*context.span).length)

    return shifted


def _first_time(context: Context, inner: Expression, *, is_last: bool = False) -> Floats:
    first = np.full(COUNT, np.nan)
    for times, is_so in moments(context, inner):
        place = len(times) - 1 - is_so[::-1].argmax(axis=0) if is_last else is_so.argmax(axis=0)
        is_new = is_so.any(axis=0) & (is_last | np.isnan(first))
        first = np.where(is_new, times[place], first)
    context.trace.reason = "never"
    return first


def _duration(context: Context, clock_s: Floats) -> Numbers:
    """Return times of the track's clock in seconds, or in frames where no rate is known."""
    step = context.clock_step
    return Numbers(clock_s / step, context.clock_unit, TOGETHER_S / step)


def _length(context: Context, span: Expression) -> Numbers:
    context.timed()
    if span.word == "contact":  # of several touches, without what lies between
        if not context.worlds.belief.is_contact_known:
            raise contact_unknown(context)
        touched_s = sum(end - begin for begin, end in context.worlds.contacts)
        return _duration(context, np.full(COUNT, touched_s))
    return _duration(context, evaluate(span, context).length)


def _lasts(context: Context, events: Expression) -> Numbers:
    """Return for how long some events go on, all together; what overlaps counts once."""
    context.timed()
    lasting = evaluate(events, context)
    total, until = np.zeros(COUNT), np.full(COUNT, -math.inf)
    begin, end = context.span
    for happening, is_so in zip(lasting.happenings, lasting.is_so, strict=True):
        first = np.maximum(np.maximum(happening.begin_s, begin), until)
        last = np.minimum(happening.end_s, end)
        total = total + np.where(is_so, np.maximum(last - first, 0.0), 0.0)
        until = np.where(is_so, np.maximum(until, last), until)
    return _duration(context, total)


def _time_while(context: Context, inner: Expression) -> Numbers:
    """Return for how long something is so: of each time from frame to frame its middle tells it.

    Events begin and end at frames: what lasts is as long as from its begin to its end.
    """
    ends = [middle(context, each) for each in context.span]
    edges = np.unique(np.clip([ends[0], *grid(context), ends[1]], *ends))
    total, at = np.zeros(COUNT), 0
    lengths, middles = np.diff(edges), (edges[1:] + edges[:-1]) / 2
    for part, holds in moments(context, inner, middles):
        total = total + lengths[at : at + len(part)] @ holds
        at += len(part)
    return _duration(context, total)


def _share(context: Context, inner: Expression) -> Numbers:
    length = Spot(*context.span).length
    share = _time_while(context, inner).values / np.maximum(length, 1e-9)
    return Numbers(100 * np.minimum(share, 1.0), "percent", 2.0)


def _count(context: Context, events: Expression) -> Numbers:
    return Numbers(evaluate(events, context).is_so.sum(axis=0).astype(float), "")


def _delay(context: Context, early: Expression, late: Expression) -> Numbers:
    require_over(context, early, late)
    far = np.asarray(evaluate(late, context)) - np.asarray(evaluate(early, context))
    return _duration(context, np.broadcast_to(far, (COUNT,)))


def _clock(context: Context, time: Expression) -> Numbers:
    require_over(context, time)
    at = np.asarray(evaluate(time, context)) - context.timed().begin_s
    return _duration(context, np.broadcast_to(at, (COUNT,)))


def _between(context: Context, early: Expression, late: Expression) -> Spot:
    ends = evaluate(early, context), evaluate(late, context)
    return Spot(np.minimum(*ends), np.maximum(*ends))


def _trimmed(context: Context, far: Expression, span: Expression, *, is_final: bool) -> Spot:
    context.timed()
    spot = evaluate(span, context)
    length = np.minimum(_stated_time(context, far, spot.length), spot.length)
    begin, end = (spot.end - length, spot.end) if is_final else (spot.begin, spot.begin + length)
    return Spot(begin, end)


def _beyond(context: Context, time: Expression, *, is_until: bool) -> Spot:
    context.timed()
    begin, end = context.contact
    at = evaluate(time, context)
    return Spot(np.minimum(begin, at), at) if is_until else Spot(at, np.maximum(end, at))


def _part(context: Context, k: Expression, n: Expression, span: Expression) -> Spot:
    context.timed()
    spot = evaluate(span, context)
    place, count = (middle(context, evaluate(each, context).values) for each in (k, n))
    if not 1 <= place <= count:
        raise Untold("span")
    step = (np.asarray(spot.end) - spot.begin) / count
    return Spot(spot.begin + (place - 1) * step, spot.begin + place * step)


def _around(context: Context, time: Expression, far: Expression) -> Spot:
    at = evaluate(time, context)
    half = _stated_time(context, far, Spot(*context.span).length)
    return Spot(at - half, at + half)


def _events(kind: str):
    def events(context: Context) -> Events:
        """Return what happens of a kind in the span, by when it begins."""
        worlds = context.timed()
        of_contact = ("touch", "none", "in", "out", "press", "contact")
        if kind in of_contact and not worlds.belief.is_contact_known:
            raise contact_unknown(context)
        happenings, masks = [], []
        begin, end = (np.asarray(each) for each in context.span)
        for happening, is_so in _of_kind(worlds, kind):
            is_inside = (end >= happening.begin_s) & (begin <= happening.end_s)
            if happening.begin_s < happening.end_s:  # an instant's overlap is none
                overlap = np.minimum(end, happening.end_s) - np.maximum(begin, happening.begin_s)
                is_inside = is_inside & (overlap > 1e-9)
            happenings.append(happening)
            masks.append(np.broadcast_to(is_so & is_inside, (COUNT,)))
            context.trace.happenings[id(happening)] = happening
        return Events.of(happenings, masks)

    return events


_KINDS = {
    "turn": (EventKind.TURN,),
    "slide": (EventKind.SLIDE,),
    "move": (EventKind.TURN, EventKind.SLIDE),
    "press": (EventKind.PRESS,),
    "touch": (EventKind.TOUCH,),
    "still": (EventKind.STICK,),
}
_SIDES = {"x": ("left", "right"), "y": ("up", "down")}


def _of_kind(worlds: Worlds, kind: str) -> Iterator[tuple[Happening, Bools]]:
    """Yield happenings, and in which worlds each is of a kind."""
    if kind in ("pause", "contact"):
        touching = (_lasting(EventKind.TOUCH, *span, worlds.touches) for span in worlds.contacts)
        spans = _pauses(worlds) if kind == "pause" else touching
        yield from ((span, span.is_real) for span in spans)
        return
    before = np.zeros(COUNT)
    for happening in worlds.happenings:
        if kind == "reverse":
            if happening.kind is EventKind.TURN:
                sign = np.sign(happening.twist[:, 0])
                yield happening, happening.is_real & (sign * before < 0)
                before = np.where(happening.is_real, sign, before)
        elif kind == "slip":
            is_slide = happening.kind is EventKind.SLIDE
            if is_slide or (happening.kind is EventKind.TURN and _follows_rest(worlds, happening)):
                yield happening, happening.is_real
        elif kind == "none":
            if happening.kind is EventKind.RELEASE and _lets_go(worlds, happening):
                yield happening, happening.is_real
        elif kind == "any":
            yield happening, happening.is_real
        elif kind in WAYS or kind in _SIDES:
            ways = [
                way for way in _SIDES.get(kind, (kind,)) if COMPONENT[way] is happening.component
            ]
            if ways:
                yield (
                    happening,
                    happening.is_real & np.any([_goes(happening, way) for way in ways], 0),
                )
        elif happening.kind in _KINDS[kind]:
            yield happening, happening.is_real


def _goes(happening: Happening, way: str) -> Bools:
    along = happening.twist @ np.array(AXIS[way], dtype=float)
    is_slide = happening.kind is EventKind.SLIDE
    far = np.abs(happening.twist[:, 1:3]).max(axis=1) if is_slide else along
    return (along > 0) & (along >= ASLANT * far)


def _lets_go(worlds: Worlds, release: Happening) -> bool:
    held_s = unseen_ends(worlds).get("end")
    ends = (end for _, end in worlds.contacts if end != held_s)
    return any(abs(release.end_s - end) <= TOGETHER_S for end in ends)


def _follows_rest(worlds: Worlds, moved: Happening) -> bool:
    return any(
        rest.kind is EventKind.STICK and abs(rest.end_s - moved.begin_s) <= 1e-9
        for rest in worlds.happenings
    )


def _pauses(worlds: Worlds) -> list[Happening]:
    """Return the rests between motions: where nothing turns or slides, and something did before."""
    moving = [
        (each.begin_s, each.end_s)
        for each in worlds.motions()
        if each.kind in _KINDS["move"] and each.probability >= 0.5
    ]
    if not moving:
        return []
    whole = (min(begin for begin, _ in moving), max(end for _, end in moving))
    return [_lasting(EventKind.STICK, *span, worlds.touches) for span in gaps(moving, whole)]


def _lasting(kind: EventKind, begin_s: float, end_s: float, is_real: Bools) -> Happening:
    return replace(instant(kind, begin_s, is_real), end_s=end_s)


def _gaps(context: Context, inner: Expression) -> Events:
    """Return the times between what likely happens of some events."""
    spans = [
        _lasting(EventKind.STICK, before.end_s, after.begin_s, before.is_real & after.is_real)
        for before, after in pairwise(evaluate(inner, context).likely)
        if after.begin_s > before.end_s
    ]
    return Events.of(spans, [each.is_real for each in spans])


def _such(context: Context, condition: Expression, inner: Expression) -> Events:
    events, masks = evaluate(inner, context), []
    for happening, is_so in zip(events.happenings, events.is_so, strict=True):
        is_met = evaluate(condition, context.within(*happening.ends))
        masks.append(is_so & (np.nan_to_num(is_met) > 0))
    return Events.of(events.happenings, masks)


def _picked(
    context: Context,
    events: Events,
    is_it: Bools,
    score: Floats | float = 0.0,
    of_what: Expression | None = None,
) -> Spot:
    """Return the one of some events with the highest score in each world; NaN where there is none.

    Args:
        context: Where it is told that a world lacks one.
        events: To pick from.
        is_it: In which worlds each may be picked, (events, COUNT).
        score: Of each, as broadcast to that.
        of_what: What is told to be lacking where it is.
    """
    if not is_it.any(axis=0).all():
        context.trace.reason = "none-such"
    if is_it.any(axis=0).mean() < 0.5:
        context.trace.lacking = of_what
    if not events.happenings:
        nowhere = np.full(COUNT, np.nan)
        return Spot(nowhere, nowhere)
    ends = np.array([(each.begin_s, each.end_s) for each in events.happenings])
    place = np.where(is_it, score, -np.inf).argmax(axis=0)
    spans = np.where(is_it.any(axis=0)[:, None], ends[place], np.nan)
    return Spot(spans[:, 0], spans[:, 1])


def _nth(context: Context, k: Expression, inner: Expression) -> Spot:
    events, place = evaluate(inner, context), evaluate(k, context).values
    is_it = events.is_so & (np.cumsum(events.is_so, axis=0) == place)
    return _picked(context, events, is_it, of_what=p.of("nth", k, inner))


def _last(context: Context, inner: Expression) -> Spot:
    events = evaluate(inner, context)
    order = np.arange(len(events.happenings))[:, None]
    return _picked(context, events, events.is_so, order, inner)


_SIZES: dict[str, Callable[[Happening], Floats]] = {
    "largest": lambda each: each.path_px,
    "longest": lambda each: np.asarray(each.end_s - each.begin_s),
    "fastest": lambda each: each.path_px / max(each.end_s - each.begin_s, 1e-9),
}
_LEAST = dict(zip(("smallest", "shortest", "slowest"), _SIZES.values(), strict=True))


def _most(size: Callable[[Happening], Floats], sign: float):
    def most(context: Context, inner: Expression) -> Spot:
        events = evaluate(inner, context)
        sizes = np.array([np.broadcast_to(size(each), (COUNT,)) for each in events.happenings])
        return _picked(context, events, events.is_so, sign * sizes.reshape(-1, COUNT), inner)

    return most


def _beside(context: Context, inner: Expression, others: Expression, *, is_next: bool) -> Spot:
    spot, events = evaluate(inner, context), evaluate(others, context)
    begins = np.array([each.begin_s for each in events.happenings])[:, None]
    is_it = events.is_so & (begins > spot.begin if is_next else begins < spot.begin)
    order = np.arange(len(begins))[:, None]
    return _picked(context, events, is_it, -order if is_next else order)


def _nothing_before(_: Context, *__: Expression) -> Spot:
    raise Untold("before")


PRIMITIVES |= {
    "length": _length,
    "lasts": _lasts,
    "time-while": _time_while,
    "share": _share,
    "count": _count,
    "delay": _delay,
    "clock": _clock,
    **{word: _nothing_before for word in p.LEANING},
    "t": _moment,
    "begin": _edge("begin"),
    "end": _edge("end"),
    "later": _shifted(1),
    "earlier": _shifted(-1),
    "first-time": _first_time,
    "last-time": partial(_first_time, is_last=True),
    "recording": lambda context: Spot(*context.recorded),
    "contact": lambda context: Spot(*context.contact),
    "here": lambda context: Spot(*context.span),
    "between": _between,
    "initial": partial(_trimmed, is_final=False),
    "final": partial(_trimmed, is_final=True),
    "until": partial(_beyond, is_until=True),
    "since": partial(_beyond, is_until=False),
    "part": _part,
    "around": _around,
    "first": lambda context, events: _nth(context, p.of("1"), events),
    "last": _last,
    "nth": _nth,
    **{name: _most(size, 1.0) for name, size in _SIZES.items()},
    **{name: _most(size, -1.0) for name, size in _LEAST.items()},
    "next": partial(_beside, is_next=True),
    "previous": partial(_beside, is_next=False),
    "such": _such,
    "gaps": _gaps,
    **{f"{kind}{p.EVENTS}": _events(kind) for kind in p.KINDS},
}
