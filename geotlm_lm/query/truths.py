"""Truths: logic, comparisons, order in time, and how two clips compare."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import Edit, opposite
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.motion.belief import PX_PER_MM
from geotlm_lm.query import program as p
from geotlm_lm.query.arithmetic import compared
from geotlm_lm.query.evaluate import (
    PRIMITIVES,
    Context,
    Floats,
    contact_middle,
    evaluate,
    moments,
    of_clip,
    placed,
)
from geotlm_lm.query.measures import holds, net
from geotlm_lm.query.program import ATOM_OF, AXIS, COMPONENT, WAY_ATOMS, WAYS, Expression, Quantity
from geotlm_lm.query.worlds import COUNT

FASTER = 1.1
"""Speed of the second half of a motion over that of its first from which on it speeds up."""


def _and(context: Context, left: Expression, right: Expression) -> Floats:
    first, second = evaluate(left, context), evaluate(right, context)
    return np.where((first == 0) | (second == 0), 0.0, first * second)


def _or(context: Context, left: Expression, right: Expression) -> Floats:
    first, second = evaluate(left, context), evaluate(right, context)
    return np.where((first == 1) | (second == 1), 1.0, 1 - (1 - first) * (1 - second))


def _truth(is_so: NDArray[np.bool_], *numbers: Floats) -> Floats:
    missing = sum(np.isnan(each) for each in numbers)
    return np.where(missing > 0, np.nan, is_so.astype(float))


def _relation(compare: Callable[[Floats, Floats], Any]):
    def relation(context: Context, left: Expression, right: Expression) -> Floats:
        first, second = compared(context, left, right)
        return _truth(compare(first.values, second.values), first.values, second.values)

    return relation


def _about(context: Context, left: Expression, right: Expression) -> Floats:
    first, second = compared(context, left, right)
    far = max(first.tolerance, second.tolerance)
    far = np.maximum(far, RELATIVE_TOLERANCE * np.abs(second.values)) if first.unit else 0.0
    return _truth(np.abs(first.values - second.values) <= far, first.values, second.values)


def _in_range(context: Context, inner: Expression, low: Expression, high: Expression) -> Floats:
    units = [each.value.unit for each in (low, high) if isinstance(each.value, Quantity)]
    shared = next((unit for unit in units if unit), "")

    def with_unit(end: Expression) -> Expression:
        is_bare = isinstance(end.value, Quantity) and not end.value.unit
        return p.number(Quantity(end.value.value, shared)) if is_bare else end

    first, least = compared(context, inner, with_unit(low))
    same, most = compared(context, inner, with_unit(high))
    ends = np.sort(np.stack(np.broadcast_arrays(least.values, most.values)), axis=0)
    is_so = (first.values >= ends[0]) & (same.values <= ends[1])
    return _truth(is_so, first.values, ends[0], ends[1])


def _before(context: Context, left: Expression, right: Expression) -> Floats:
    # What never happens is neither before nor after anything.
    return (np.asarray(evaluate(left, context)) < evaluate(right, context)).astype(float)


def _lies(context: Context, half: str) -> Floats:
    x, y = contact_middle(context)
    is_so = {"upper": y < 0.5, "lower": y > 0.5, "left-half": x < 0.5, "right-half": x > 0.5}[half]
    return np.full(COUNT, float(is_so))


def _speeds(sign: int):
    def changes(context: Context, atom: str) -> Floats:
        context.timed()
        span, path = p.of("largest", p.of(f"{atom}{p.EVENTS}")), p.of("path", atom)
        halves = (p.of("part", p.of(half), p.of("2"), span) for half in ("1", "2"))
        first, second = (evaluate(p.of("within", half, path), context).values for half in halves)
        ratio = second / np.where(first > 0, first, np.nan)
        return _truth(ratio**sign > FASTER, ratio)

    return changes


def _over_moments(combine: Callable[..., Any]):
    def combined(context: Context, inner: Expression) -> Floats:
        parts = [combine(is_so, axis=0) for _, is_so in moments(context, inner)]
        return combine(parts, axis=0) * 1.0

    return combined


# Two clips


def _clips(combine: Callable[[Expression, Expression], Expression]):
    """Return what asks the same of both clips and combines it."""

    def combined(context: Context, inner: Expression) -> Any:
        return evaluate(combine(p.of("of-first", inner), p.of("of-second", inner)), context)

    return combined


def _two_ways(related: Callable[[Motion], Motion], *, with_rest: bool = True):
    """Return what tells whether the second clip goes as the first one's way makes expect."""
    codes = [WAYS.index(ATOM_OF[related(way)]) for way in WAY_ATOMS.values()]
    table = np.array([*codes, -1 if with_rest else len(WAYS)])

    def compare(context: Context, inner: Expression) -> Floats:
        whole = replace(context, now=None)
        clips = (of_clip(whole, clip) for clip in ("of-first", "of-second"))
        first, second = (_main_way(inner, clip) for clip in clips)
        if inner.word == "kind":
            kinds = np.array([COMPONENTS.index(COMPONENT[way]) for way in WAYS] + [-1])
            return (kinds[first] == kinds[second]).astype(float)
        return (table[first] == second).astype(float)

    return compare


def _main_way(expression: Expression, context: Context) -> NDArray[np.int64]:
    """Return which way what moves farthest goes in each world; -1 where nothing does."""
    inner, context = placed(expression, context)
    asked = inner.arguments[0] if inner.word == "way" else "all"
    best, main = np.zeros(COUNT), np.full(COUNT, -1)
    radius = max(context.worlds.belief.radius_px, 1.0)
    scale = dict(zip(COMPONENTS, (math.radians(radius), 1.0, PX_PER_MM), strict=True))
    for component in (each for each in COMPONENTS if asked in ("all", each.value)):
        moves = holds(context, component.value)
        twist = np.broadcast_to(net(context, component)[0], (COUNT, 4))
        ways = [way for way in WAYS if COMPONENT[way] is component]
        along = twist @ np.array([AXIS[way] for way in ways], float).T
        far = along.max(axis=1) * scale[component]
        is_it = moves & (far > best)
        codes = np.array([WAYS.index(way) for way in ways])[along.argmax(axis=1)]
        best, main = np.where(is_it, far, best), np.where(is_it, codes, main)
    return main


PRIMITIVES |= {
    "not": lambda context, inner: 1 - evaluate(inner, context),
    "and": _and,
    "or": _or,
    "xor": lambda context, left, right: np.abs(evaluate(left, context) - evaluate(right, context)),
    ">": _relation(np.greater),
    "<": _relation(np.less),
    "=": _relation(np.isclose),
    "~": _about,
    "in-range": _in_range,
    "happens": lambda context, inner: evaluate(inner, context).is_so.any(axis=0).astype(float),
    "before": _before,
    "after": lambda context, left, right: _before(context, right, left),
    "ever": _over_moments(np.any),
    "always": _over_moments(np.all),
    "lies": _lies,
    "speeds-up": _speeds(1),
    "slows-down": _speeds(-1),
    "same": _two_ways(lambda way: way),
    "opposite": _two_ways(opposite, with_rest=False),  # what rests is no opposite of itself
    "mirrored": _two_ways(Edit.of("mirror").of_way),
    "both": _clips(lambda first, second: p.of("and", first, second)),
    "either": _clips(lambda first, second: p.of("or", first, second)),
    "neither": _clips(lambda first, second: p.of("not", p.of("or", first, second))),
    "only-one": _clips(
        lambda first, second: p.of(
            "and", p.of("or", first, second), p.of("not", p.of("and", first, second))
        )
    ),
    "more": _clips(lambda first, second: p.of(">", first, second)),
    "less": _clips(lambda first, second: p.of("<", first, second)),
    "as-far": _clips(lambda first, second: p.of("~", first, second)),
}
