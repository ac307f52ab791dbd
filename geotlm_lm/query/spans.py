"""Moments, spans of time and what happens in a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import (
    PRIMITIVES,
    WAY,
    Context,
    Events,
    Floats,
    Spot,
    Untold,
    evaluate,
    middle,
    moments,
)
from geotlm_lm.query.measures import length_of
from geotlm_lm.query.program import Expression
from geotlm_lm.query.truths import ASLANT
from geotlm_lm.query.units import clock_unit, converted
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
    if clock_unit(context) != "s":
        raise Untold("rate")
    return converted(context, replace(stated, unit=unit), "s").values


def duration(context: Context, inner: Expression, whole: Floats) -> Floats:
    """Return a stated time span on the recording's clock; a share is one of `whole`."""
    stated = evaluate(inner, context)
    if stated.unit == "percent":
        return stated.values / 100 * whole
    if stated.unit == "frame":
        track = context.timed().track
        steps = max(int(track.numbers[-1] - track.numbers[0]), 1)
        return stated.values * track.seconds / steps
    if clock_unit(context) != "s":
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
        return at + sign * duration(context, by, length_of(Spot(*context.span)))

    return shifted


def _first_time(context: Context, inner: Expression, *, is_last: bool = False) -> Floats:
    first = np.full(COUNT, np.nan)
    for times, is_so in moments(context, inner):
        place = len(times) - 1 - is_so[::-1].argmax(axis=0) if is_last else is_so.argmax(axis=0)
        is_new = is_so.any(axis=0) & (is_last | np.isnan(first))
        first = np.where(is_new, times[place], first)
    context.trace.reason = "never"
    return first


# Numbers


def _recording(context: Context) -> Spot:
    worlds = context.worlds
    return Spot(np.asarray(worlds.begin_s), np.asarray(worlds.end_s))


def _contact(context: Context) -> Spot:
    return Spot(*context.contact)


def _here(context: Context) -> Spot:
    return Spot(*context.span)


def _between(context: Context, early: Expression, late: Expression) -> Spot:
    one, two = evaluate(early, context), evaluate(late, context)
    return Spot(np.minimum(one, two), np.maximum(one, two))


def _trimmed(context: Context, far: Expression, span: Expression) -> tuple[Spot, Floats]:
    context.timed()
    spot = evaluate(span, context)
    length = length_of(spot)
    return spot, np.minimum(duration(context, far, length), length)


def _initial(context: Context, far: Expression, span: Expression) -> Spot:
    spot, length = _trimmed(context, far, span)
    return Spot(spot.begin, spot.begin + length)


def _final(context: Context, far: Expression, span: Expression) -> Spot:
    spot, length = _trimmed(context, far, span)
    return Spot(spot.end - length, spot.end)


def _until(context: Context, time: Expression) -> Spot:
    context.timed()
    begin, _ = context.contact
    at = evaluate(time, context)
    return Spot(np.minimum(begin, at), at)


def _since(context: Context, time: Expression) -> Spot:
    context.timed()
    _, end = context.contact
    at = evaluate(time, context)
    return Spot(at, np.maximum(end, at))


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
    half = duration(context, far, length_of(Spot(*context.span)))
    return Spot(at - half, at + half)


def events(context: Context, kind: str) -> Events:
    """Return what happens of a kind in the span, by when it begins."""
    worlds = context.timed()
    if kind in ("touch", "none", "in", "out", "press") and not worlds.belief.is_contact_known:
        raise Untold("contact")
    happenings, masks = [], []
    begin, end = context.span
    for happening, is_so in _of_kind(worlds, kind):
        is_inside = (np.asarray(end) >= happening.begin_s) & (np.asarray(begin) <= happening.end_s)
        if happening.begin_s < happening.end_s:  # an instant's overlap is none
            overlap = np.minimum(end, happening.end_s) - np.maximum(begin, happening.begin_s)
            is_inside = is_inside & (overlap > 1e-9)
        happenings.append(happening)
        masks.append(np.broadcast_to(is_so & is_inside, (COUNT,)))
        context.trace.happenings[id(happening)] = happening
    return Events(tuple(happenings), np.array(masks, dtype=bool).reshape(len(masks), COUNT))


def _events(kind: str):
    return lambda context: events(context, kind)


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
        spans = _pauses(worlds) if kind == "pause" else _contacts(worlds)
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
            if happening.kind in _KINDS["move"] and _follows_rest(worlds, happening):
                yield happening, happening.is_real
        elif kind == "none":
            if happening.kind is EventKind.RELEASE and _lets_go(worlds, happening):
                yield happening, happening.is_real
        elif kind == "any":
            yield happening, happening.is_real
        elif kind in WAY or kind in _SIDES:
            ways = [way for way in _SIDES.get(kind, (kind,)) if WAY[way][0] is happening.component]
            if ways:
                yield (
                    happening,
                    happening.is_real & np.any([_goes(happening, way) for way in ways], 0),
                )
        elif happening.kind in _KINDS[kind]:
            yield happening, happening.is_real


def _goes(happening: Happening, way: str) -> Bools:
    along = happening.twist @ np.array(WAY[way][1], dtype=float)
    is_slide = happening.kind is EventKind.SLIDE
    far = np.abs(happening.twist[:, 1:3]).max(axis=1) if is_slide else along
    return (along > 0) & (along >= ASLANT * far)


def _lets_go(worlds: Worlds, release: Happening) -> bool:
    return any(abs(release.end_s - end) <= TOGETHER_S for _, end in worlds.contacts)


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
        if each.kind in (EventKind.TURN, EventKind.SLIDE) and each.probability >= 0.5
    ]
    if not moving:
        return []
    whole = (min(begin for begin, _ in moving), max(end for _, end in moving))
    return [replace(instant(EventKind.STICK, begin, worlds.touches), end_s=end)
             for begin, end in gaps(moving, whole)]  # fmt: skip


def _contacts(worlds: Worlds) -> list[Happening]:
    return [replace(instant(EventKind.TOUCH, begin, worlds.touches), end_s=end)
            for begin, end in worlds.contacts]  # fmt: skip


def _gaps(context: Context, inner: Expression) -> Events:
    """Return the times between what likely happens of some events."""
    events = evaluate(inner, context)
    likely = [each for each, is_so in zip(events.happenings, events.is_so, strict=True)
              if is_so.mean() >= 0.5]  # fmt: skip
    spans = [
        replace(instant(EventKind.STICK, one.end_s, one.is_real & two.is_real), end_s=two.begin_s)
        for one, two in pairwise(likely)
        if two.begin_s > one.end_s
    ]
    masks = np.array([each.is_real for each in spans], dtype=bool)
    return Events(tuple(spans), masks.reshape(len(spans), COUNT))


def _such(context: Context, condition: Expression, inner: Expression) -> Events:
    events = evaluate(inner, context)
    if not events.happenings:
        return events
    masks = []
    for happening, is_so in zip(events.happenings, events.is_so, strict=True):
        ends = np.asarray(happening.begin_s), np.asarray(happening.end_s)
        holds = evaluate(condition, context.within(*ends))
        masks.append(is_so & (np.nan_to_num(holds) > 0))
    return Events(events.happenings, np.array(masks))


def _picked(context: Context, events: Events, place: NDArray[np.int64]) -> Spot:
    """Return one of some events in each world; none where `place` is negative."""
    if not events.happenings:
        context.trace.reason = "none-such"
        nowhere = np.full(COUNT, np.nan)
        return Spot(nowhere, nowhere)
    ends = np.array([(each.begin_s, each.end_s) for each in events.happenings])
    spans = np.where((place >= 0)[:, None], ends[np.maximum(place, 0)], np.nan)
    if (place < 0).any():
        context.trace.reason = "none-such"
    return Spot(spans[:, 0], spans[:, 1])


def _nth(context: Context, events: Events, count: Floats) -> Spot:
    if not events.happenings:
        return _picked(context, events, np.full(COUNT, -1))
    order = np.cumsum(events.is_so, axis=0)
    is_it = events.is_so & (order == count)
    return _picked(context, events, np.where(is_it.any(axis=0), is_it.argmax(axis=0), -1))


def _first(context: Context, inner: Expression) -> Spot:
    return _nth(context, evaluate(inner, context), np.ones(COUNT))


def _last(context: Context, inner: Expression) -> Spot:
    events = evaluate(inner, context)
    return _nth(context, events, events.is_so.sum(axis=0).astype(float))


def _of_number(context: Context, k: Expression, inner: Expression) -> Spot:
    return _nth(context, evaluate(inner, context), evaluate(k, context).values)


_SIZES: dict[str, Callable[[Happening], Floats]] = {
    "largest": lambda each: each.path_px,
    "longest": lambda each: np.asarray(each.end_s - each.begin_s),
    "fastest": lambda each: each.path_px / max(each.end_s - each.begin_s, 1e-9),
}
_LEAST = dict(zip(("smallest", "shortest", "slowest"), _SIZES.values(), strict=True))


def _most(size: Callable[[Happening], Floats], *, least: bool = False):
    sign = -1.0 if least else 1.0

    def most(context: Context, inner: Expression) -> Spot:
        events = evaluate(inner, context)
        if not events.happenings:
            return _picked(context, events, np.full(COUNT, -1))
        sizes = np.array([np.broadcast_to(size(each), (COUNT,)) for each in events.happenings])
        sizes = np.where(events.is_so, sign * sizes, -np.inf)
        is_any = np.isfinite(sizes.max(axis=0))
        return _picked(context, events, np.where(is_any, sizes.argmax(axis=0), -1))

    return most


def _beside(context: Context, inner: Expression, others: Expression, *, is_next: bool) -> Spot:
    spot, events = evaluate(inner, context), evaluate(others, context)
    if not events.happenings:
        return _picked(context, events, np.full(COUNT, -1))
    begins = np.array([each.begin_s for each in events.happenings])[:, None]
    is_it = events.is_so & (begins > spot.begin if is_next else begins < spot.begin)
    place = is_it.argmax(axis=0) if is_next else len(begins) - 1 - is_it[::-1].argmax(axis=0)
    return _picked(context, events, np.where(is_it.any(axis=0), place, -1))


def _nothing_before(_: Context, *__: Expression) -> Spot:
    raise Untold("before")


PRIMITIVES |= {
    **{word: _nothing_before for word in p.LEANING},
    "t": _moment,
    "begin": _edge("begin"),
    "end": _edge("end"),
    "later": _shifted(1),
    "earlier": _shifted(-1),
    "first-time": _first_time,
    "last-time": lambda context, inner: _first_time(context, inner, is_last=True),
    "recording": _recording,
    "contact": _contact,
    "here": _here,
    "between": _between,
    "initial": _initial,
    "final": _final,
    "until": _until,
    "since": _since,
    "part": _part,
    "around": _around,
    "first": _first,
    "last": _last,
    "nth": _of_number,
    **{name: _most(size) for name, size in _SIZES.items()},
    **{name: _most(size, least=True) for name, size in _LEAST.items()},
    "next": lambda context, one, others: _beside(context, one, others, is_next=True),
    "previous": lambda context, one, others: _beside(context, one, others, is_next=False),
    "such": _such,
    "gaps": _gaps,
    **{f"{kind}{p.EVENTS}": _events(kind) for kind in p.KINDS},
}
