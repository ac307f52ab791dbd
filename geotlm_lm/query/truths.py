"""Truths: what is so of a span or a moment, logic, comparisons, and how two clips compare."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import EDIT_WORDS
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import COMPONENTS, MOVING_PX, Component
from geotlm_lm.motion.belief import PX_PER_MM
from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import (
    COMPONENT,
    PRIMITIVES,
    WAY,
    Context,
    Floats,
    Untold,
    evaluate,
    inside,
    moments,
    of_clip,
)
from geotlm_lm.query.measures import net, placed
from geotlm_lm.query.program import Expression
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.units import compared
from geotlm_lm.query.worlds import COUNT

ASLANT = 1 / 3
"""Share of a slide's lesser travel in its greater from which on it is said to go that way too, and
of a turn's way back in its way there."""


def trait(context: Context, word: str) -> Floats:
    """Tell in which worlds something is so of the span, or of the moment."""
    worlds = context.worlds
    if word in ("touch", "none", "in", "out", "press") and not worlds.belief.is_contact_known:
        raise Untold("contact")
    if word in ("touch", "none"):
        touches = _touched(context)
        return touches if word == "touch" else 1 - touches
    if word == "still":
        moves = reduce(np.maximum, (_moves(context, component) for component in COMPONENTS))
        return _touched(context) * (1 - moves)
    if word == "move":
        known = COMPONENTS if worlds.belief.is_contact_known else COMPONENTS[:2]
        return reduce(np.maximum, (_moves(context, component) for component in known))
    if word in ("x", "y"):
        sides = ("left", "right") if word == "x" else ("up", "down")
        return np.maximum(*(_goes(context, side) for side in sides))
    if word in ("tighten", "loosen"):
        ways = [_goes(context, way) * (_tightens(context, way) == (word == "tighten"))
                for way in ("cw", "ccw")]  # fmt: skip
        return np.maximum(*ways)
    context.trace.components[COMPONENT[word]] = None
    return _moves(context, COMPONENT[word]) if word in p.COMPONENTS else _goes(context, word)


def _trait(word: str):
    return lambda context: trait(context, word)


def _touched(context: Context) -> Floats:
    worlds = context.worlds
    begin, end = context.span if context.now is None else (context.now, context.now)
    inside = np.zeros(np.broadcast(begin, end).shape, bool)
    for first, last in worlds.contacts:
        inside = inside | ((np.asarray(begin) <= last) & (np.asarray(end) >= first))
    return (worlds.touches & inside).astype(float)


def _parts(context: Context, component: Component):
    """Yield what moves of a component: in which worlds, and the share of it that lies inside."""
    if context.now is None:
        for happening, share in inside(context, component):
            least = np.minimum(MOVING_PX, 0.999 * happening.path_px)
            yield happening, happening.is_real & (share * happening.path_px >= least), share
        return
    now = np.asarray(context.now)
    for happening in context.worlds.motions(component):
        if happening.begin_s <= np.max(now) and happening.end_s >= np.min(now):
            goes_on = (happening.begin_s <= now) & (now <= happening.end_s)
            yield happening, happening.is_real & goes_on, 1.0


def _moves(context: Context, component: Component) -> Floats:
    moves = np.zeros(COUNT, bool)
    for happening, is_so, _ in _parts(context, component):
        if component is Component.PRESS and happening.is_edge:
            continue  # what begins or ends contact is a touch or a release and no press
        moves = moves | is_so
    return moves.astype(float)


def _goes(context: Context, way: str) -> Floats:
    """Tell in which worlds it goes a way: by a third of the farthest that it goes any way."""
    component = COMPONENT[way]
    context.trace.components[component] = None
    rivals = [other for other in WAY if COMPONENT[other] is component]
    ways = {name: np.zeros(COUNT) for name in rivals}
    for happening, is_so, share in _parts(context, component):
        if component is Component.PRESS and happening.is_edge:
            continue
        for name in rivals:
            along = happening.twist @ np.array(WAY[name][1], dtype=float)
            ways[name] = ways[name] + np.where(is_so, share * np.maximum(along, 0.0), 0.0)
    farthest = np.maximum.reduce([np.broadcast_to(each, ways[way].shape) for each in ways.values()])
    return ((ways[way] > 0) & (ways[way] >= ASLANT * farthest)).astype(float)


def _tightens(context: Context, way: str) -> bool:
    frame = context.frame
    if frame.contact_side == "side":
        raise Untold("side")
    if frame.missing_for_thread():
        if _moves(context, Component.TURN).mean() < 0.5:
            return way == "cw"  # it hardly turns: neither is probable, whatever thread
        raise Untold("thread")
    # A mirror that is only supposed would make another thread; who looks from where does not.
    supposed = replace(context.edit, behind=False, sensor=False)
    supposed = replace(supposed, rotation=context.edit.image)
    motion = {"cw": Motion.CLOCKWISE, "ccw": Motion.COUNTERCLOCKWISE}[way]
    recorded = context.view.inverse().of_way(motion)
    return bool(frame.tightens(supposed.of_way(recorded)))


def _not(context: Context, inner: Expression) -> Floats:
    return 1 - evaluate(inner, context)


def _and(context: Context, left: Expression, right: Expression) -> Floats:
    one, two = evaluate(left, context), evaluate(right, context)
    return np.where((one == 0) | (two == 0), 0.0, one * two)


def _or(context: Context, left: Expression, right: Expression) -> Floats:
    one, two = evaluate(left, context), evaluate(right, context)
    return np.where((one == 1) | (two == 1), 1.0, 1 - (1 - one) * (1 - two))


def _truth(holds: NDArray[np.bool_], *numbers: Floats) -> Floats:
    missing = sum(np.isnan(each) for each in numbers)
    return np.where(missing > 0, np.nan, holds.astype(float))


def _relation(compare: Callable[[Floats, Floats], Any]):
    def relation(context: Context, left: Expression, right: Expression) -> Floats:
        one, two = compared(context, left, right)
        return _truth(compare(one.values, two.values), one.values, two.values)

    return relation


def _about(context: Context, left: Expression, right: Expression) -> Floats:
    one, two = compared(context, left, right)
    far = max(one.tolerance, two.tolerance)
    far = np.maximum(far, RELATIVE_TOLERANCE * np.abs(two.values)) if one.unit else 0.0
    return _truth(np.abs(one.values - two.values) <= far, one.values, two.values)


def _in_range(context: Context, inner: Expression, low: Expression, high: Expression) -> Floats:
    units = [each.value.unit for each in (low, high) if isinstance(each.value, Quantity)]
    shared = next((unit for unit in units if unit), "")

    def with_unit(end: Expression) -> Expression:
        if isinstance(end.value, Quantity) and not end.value.unit:
            return p.number(Quantity(end.value.value, shared))
        return end

    one, least = compared(context, inner, with_unit(low))
    same, most = compared(context, inner, with_unit(high))
    ends = np.sort(np.stack(np.broadcast_arrays(least.values, most.values)), axis=0)
    is_so = (one.values >= ends[0]) & (same.values <= ends[1])
    return _truth(is_so, one.values, ends[0], ends[1])


def _happens(context: Context, inner: Expression) -> Floats:
    return evaluate(inner, context).is_so.any(axis=0).astype(float)


def _before(context: Context, left: Expression, right: Expression) -> Floats:
    # What never happens is neither before nor after anything.
    return (np.asarray(evaluate(left, context)) < evaluate(right, context)).astype(float)


def _lies(context: Context, half: str) -> Floats:
    x, y = placed(context)
    is_so = {"upper": y < 0.5, "lower": y > 0.5, "left-half": x < 0.5, "right-half": x > 0.5}[half]
    return np.full(COUNT, float(is_so))


FASTER = 1.1
"""Speed of the second half of a motion over that of its first from which on it speeds up."""


def _speeds(sign: int):
    def changes(context: Context, atom: str) -> Floats:
        context.timed()
        span = p.of("largest", p.of(f"{atom}{p.EVENTS}"))
        two = p.of("2")
        first, second = (
            evaluate(
                p.of("within", p.of("part", p.of(half), two, span), p.of("path", atom)), context
            )
            for half in ("1", "2")
        )
        ratio = second.values / np.where(first.values > 0, first.values, np.nan)
        return _truth(ratio**sign > FASTER, ratio)

    return changes


def _ever(context: Context, inner: Expression) -> Floats:
    return np.any([holds.any(axis=0) for _, holds in moments(context, inner)], axis=0) * 1.0


def _always(context: Context, inner: Expression) -> Floats:
    return np.all([holds.all(axis=0) for _, holds in moments(context, inner)], axis=0) * 1.0


_CODES = {way: place for place, way in enumerate(WAY)}
_MIRRORED = {"cw": "ccw", "ccw": "cw", "left": "right", "right": "left"}
_OPPOSITE = {**_MIRRORED, "up": "down", "down": "up", "in": "out", "out": "in"}


def _two_ways(relation: str):
    def related(context: Context, inner: Expression) -> Floats:
        whole = replace(context, now=None)
        one, two = (_main_way(inner, of_clip(whole, clip)) for clip in ("of-first", "of-second"))
        if inner.word == "kind":
            kinds = np.array([COMPONENTS.index(COMPONENT[way]) for way in WAY] + [-1])
            return (kinds[one] == kinds[two]).astype(float)
        swapped = {"same": {}, "mirrored": _MIRRORED, "opposite": _OPPOSITE}[relation]
        table = np.array([_CODES[swapped.get(way, way)] for way in WAY] + [-1])
        # What rests is no opposite of itself.
        is_so = (table[one] == two) & ((relation != "opposite") | (one >= 0))
        return is_so.astype(float)

    return related


def _main_way(inner: Expression, context: Context) -> NDArray[np.int64]:
    """Return which way what moves farthest goes in each world; -1 where nothing does."""
    while inner.word in EDIT_WORDS or inner.word == "within":
        if inner.word == "within":
            spot = evaluate(inner.arguments[0], context)
            context = context.within(spot.begin, spot.end)
        else:
            context = context.edited(inner.word)
        inner = inner.arguments[-1]
    asked = inner.arguments[0] if inner.word == "way" else "all"
    parts = [part for part in COMPONENTS if asked in ("all", part.value)]
    best, main = np.zeros(COUNT), np.full(COUNT, -1)
    for component in parts:
        moves = np.broadcast_to(_moves(context, component), (COUNT,)) > 0
        twist = np.broadcast_to(net(context, component)[0], (COUNT, 4))
        ways = [way for way in WAY if COMPONENT[way] is component]
        along = np.stack([twist @ np.array(WAY[way][1], float) for way in ways])
        radius = max(context.worlds.belief.radius_px, 1.0)
        scale = {Component.TURN: math.radians(radius), Component.SLIDE: 1.0}
        far = along.max(axis=0) * scale.get(component, PX_PER_MM)
        is_it = moves & (far > best)
        codes = np.array([_CODES[way] for way in ways])[along.argmax(axis=0)]
        best, main = np.where(is_it, far, best), np.where(is_it, codes, main)
    return main


# Moments of a span


PRIMITIVES |= {
    "not": _not,
    "and": _and,
    "or": _or,
    "xor": lambda context, one, two: np.abs(evaluate(one, context) - evaluate(two, context)),
    ">": _relation(np.greater),
    "<": _relation(np.less),
    "=": _relation(np.isclose),
    "~": _about,
    "in-range": _in_range,
    "happens": _happens,
    "before": _before,
    "after": lambda context, one, two: _before(context, two, one),
    "ever": _ever,
    "always": _always,
    "lies": _lies,
    "speeds-up": _speeds(1),
    "slows-down": _speeds(-1),
    **{relation: _two_ways(relation) for relation in ("same", "opposite", "mirrored")},
    **{word: _trait(word) for word in p.TRAITS},
}
