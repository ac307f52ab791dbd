"""Arithmetic on numbers of every world, over events, and in units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.motion.belief import SPAN_DEVIATIONS
from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import (
    PRIMITIVES,
    Context,
    Floats,
    Numbers,
    Untold,
    contact_area,
    contact_middle,
    evaluate,
    middle,
)
from geotlm_lm.query.measures import scale_of
from geotlm_lm.query.program import Expression
from geotlm_lm.query.quantities import FACTORS, Quantity, in_base
from geotlm_lm.query.worlds import COUNT


def compared(context: Context, left: Expression, right: Expression) -> tuple[Numbers, Numbers]:
    """Return two numbers in one unit: that of a constant where one is, else of the first."""
    left, right = _counted(left, right), _counted(right, left)
    scaled = in_length_of(context, left, right)
    one, two = evaluate(left, scaled), evaluate(right, scaled)
    if left.value is not None and right.value is None:
        two, one = _alike(scaled, two, one)
        return one, two
    return _alike(scaled, one, two)


def _counted(number: Expression, beside: Expression) -> Expression:
    """Return "three turns" as three where it stands beside a count."""
    is_turns = isinstance(number.value, Quantity) and number.value.unit == "turn"
    is_count = p.head_of(p.measure_of(p.head_of(beside))).word == "count"
    return p.number(number.value.value) if is_turns and is_count else number


def _alike(context: Context, one: Numbers, two: Numbers) -> tuple[Numbers, Numbers]:
    if not two.unit and one.unit:
        is_part = one.unit == "percent" and two.tolerance == 0 and np.max(two.values) <= 1
        return one, replace(two, unit=one.unit, values=two.values * (100 if is_part else 1))
    if not one.unit and two.unit:
        return replace(one, unit=two.unit), two
    return one, converted(context, two, one.unit)


def in_length_of(context: Context, *expressions: Expression) -> Context:
    """Return a context that measures as a number is: travel in mm or px, or a turn."""
    for expression in expressions:
        units = [inner.value.unit for inner in expression if isinstance(inner.value, Quantity)]
        units += [inner.arguments[0] for inner in expression if inner.word == "unit"]
        for unit in units:
            if p.dimension_of(unit) in ("length", "angle"):
                return _measuring_in(context, unit)
    return context


def _measuring_in(context: Context, unit: str) -> Context:
    length = "px" if unit.partition("/")[0] == "px" else "mm"
    kind = p.dimension_of(unit)
    return replace(context, length={"angle": "deg", "length": length}.get(kind, context.length))


def converted(context: Context, numbers: Numbers, unit: str) -> Numbers:
    """Return numbers in another unit.

    Raises:
        Untold: If it is one of something else, or needs a scale or a rate that is not known.
    """
    factor = _factor(context, numbers.unit, unit)
    return numbers.also(numbers.values * factor, unit=unit, tolerance=numbers.tolerance * factor)


def _factor(context: Context, have: str, wanted: str) -> float:
    if have == wanted:
        return 1.0
    if "/" in have or "/" in wanted:
        top, _, per = have.partition("/")
        wanted_top, _, wanted_per = wanted.partition("/")
        if not per or not wanted_per:
            raise Untold("unit")
        return _factor(context, top, wanted_top) / _factor(context, per, wanted_per)
    for factors in FACTORS.values():
        if have in factors and wanted in factors:
            return factors[have] / factors[wanted]
    times = FACTORS["time"]
    if {have, wanted} & {"frame"} and {have, wanted} & times.keys():
        rate = context.evidence.recording.rate_hz
        if not rate:
            raise Untold("rate")
        return rate * times[have] if have in times else 1 / (rate * times[wanted])
    lengths = FACTORS["length"]
    if {have, wanted} & {"px"} and {have, wanted} & lengths.keys():
        size = context.frame.mm_per_px
        if size is None:
            raise Untold("scale")
        return lengths[have] / size if have in lengths else size / lengths[wanted]
    raise Untold("unit")


def constant(_: Context, quantity: Quantity) -> Numbers:
    """Return a number that is stated, the same in every world, in the base of its unit."""
    value, unit, per = in_base(quantity)
    if quantity.unit.partition("/")[0] == "percent":
        unit = "percent"
    return _number(value, f"{unit}/{per}" if per else unit)


SPAN = (0.05, 0.95)
"""Shares of the worlds below the ends of the span that a number is told with."""


def _number(value: float, unit: str = "", tolerance: float = 0.0) -> Numbers:
    return Numbers(np.full(COUNT, float(value)), unit, tolerance)


def _of_file(name: str, unit: str = ""):
    def stated(context: Context) -> Numbers:
        value = getattr(context.evidence.recording, name)
        if value is None:
            raise Untold("rate")
        return _number(value, unit)

    return stated


def _size(name: str):
    return lambda context: converted(context, _of_file(name, "px")(context), scale_of(context)[0])


def _area(context: Context) -> Numbers:
    area = contact_area(context)
    if area is None:
        raise Untold("share")
    return _number(100 * area.share, "percent", 5.0)


def _chance(context: Context, inner: Expression) -> Numbers:
    is_so = np.nan_to_num(evaluate(inner, context))
    share = np.broadcast_to(is_so, np.broadcast_shapes(is_so.shape, (COUNT,))).mean(-1)
    return Numbers(np.repeat(100 * share[..., None], COUNT, axis=-1), "percent", 2.0)


def _sum(sign: int):
    def added(context: Context, left: Expression, right: Expression) -> Numbers:
        one, two = compared(context, left, right)
        # A sum is right where its terms are.
        slack = max(_slack(one), _slack(two))
        return one.also(one.values + sign * two.values, atom=one.atom if one.unit else None,
                        slack=slack, is_signed=sign < 0)  # fmt: skip

    return added


def _slack(term: Numbers) -> float:
    """Return by how much a measured term may be wrong and still counts as right."""
    known = term.values[np.isfinite(term.values)]
    is_measured = bool(term.unit) and known.size > 0 and float(np.ptp(known)) > 0
    far = RELATIVE_TOLERANCE * float(np.median(np.abs(known))) if is_measured else 0.0
    return max(far, term.slack, term.tolerance)


def _times(context: Context, left: Expression, right: Expression) -> Numbers:
    one, two = (_multiplier(evaluate(each, context)) for each in (left, right))
    if one.unit and two.unit:
        for speed, time in ((one, two), (two, one)):
            if "/" in speed.unit and time.unit in p.UNITS["time"]:
                return _way_gone(context, speed, time)
        is_turn = one.unit.partition("/")[0] in p.UNITS["angle"]
        return _arc(context, *((one, two) if is_turn else (two, one)))
    # A bare constant is exact: the product is as inexact as what it is a multiple of.
    is_first = bool(one.unit) or (not two.unit and one.tolerance >= two.tolerance)
    main, other = (one, two) if is_first else (two, one)
    known = other.values[np.isfinite(other.values)]
    size = float(np.median(np.abs(known))) if known.size else 1.0
    return main.also(main.values * other.values, tolerance=main.tolerance * size)


def _multiplier(numbers: Numbers) -> Numbers:
    """Return a share as the number to multiply by: 30 percent of an angle are 0.3 of it."""
    if numbers.unit != "percent":
        return numbers
    return numbers.also(numbers.values / 100, unit="", tolerance=numbers.tolerance / 100)


def _way_gone(context: Context, speed: Numbers, time: Numbers) -> Numbers:
    """Return how far what goes at a speed gets in a time."""
    speed, time = (
        converted(context, speed, f"{speed.unit.partition('/')[0]}/s"),
        converted(context, time, "s"),
    )
    return speed.also(
        speed.values * time.values, unit=speed.unit.removesuffix("/s"),
        tolerance=speed.tolerance * float(np.median(time.values)), atom=None,
    )  # fmt: skip


def _arc(context: Context, turn: Numbers, radius: Numbers) -> Numbers:
    """Return how far what turns goes at a radius, or how fast; of counted turns at a pitch."""
    top, gap, per = turn.unit.partition("/")
    if top not in p.UNITS["angle"] or radius.unit not in p.UNITS["length"]:
        raise Untold("unit")
    if top != "turn":
        turn = converted(context, turn, f"rad{gap}{per}")
    return radius.also(
        turn.values * radius.values, unit=f"{radius.unit}{gap}{per}",
        tolerance=turn.tolerance * float(np.median(radius.values)), atom=None,
    )  # fmt: skip


def _over(context: Context, left: Expression, right: Expression) -> Numbers:
    scaled = in_length_of(context, left, right)
    one, two = evaluate(left, scaled), evaluate(right, scaled)
    with np.errstate(divide="ignore", invalid="ignore"):
        if not two.unit:
            return one.also(one.values / np.where(two.values == 0, np.nan, two.values))
        one = replace(one, unit=two.unit) if left.value is not None and not one.unit else one
        if "/" in two.unit and "/" not in one.unit:
            return _time_of(scaled, one, two)
        if "/" not in one.unit + two.unit and _kind(one.unit) != _kind(two.unit):
            over = np.where(two.values == 0, np.nan, two.values)
            known = over[np.isfinite(over)]
            size = float(np.median(np.abs(known))) if known.size else 1.0
            return one.also(one.values / over, unit=f"{one.unit}/{two.unit}",
                            tolerance=one.tolerance / size, atom=None)  # fmt: skip
        two = converted(scaled, two, one.unit)
        return Numbers(one.values / np.where(two.values == 0, np.nan, two.values), "", 0.05)


def _time_of(context: Context, way: Numbers, speed: Numbers) -> Numbers:
    """Return how long a way takes at a speed."""
    speed = converted(context, speed, f"{way.unit}/s")
    return Numbers(way.values / np.where(speed.values == 0, np.nan, speed.values), "s", 0.05)


def _kind(unit: str) -> str:
    return p.dimension_of(unit) or unit


def _percent_of(context: Context, part: Expression, whole: Expression) -> Numbers:
    one, two = compared(context, part, whole)
    known = np.where(two.values == 0, np.nan, two.values)
    return Numbers(100 * one.values / known, "percent", 2.0)


def _extreme(choose: Callable[[Floats, Floats], Floats]):
    def extreme(context: Context, left: Expression, right: Expression) -> Numbers:
        one, two = compared(context, left, right)
        return one.also(choose(one.values, two.values))

    return extreme


def _over_events(combine: Callable[[Floats], Floats]):
    def combined(context: Context, events: Expression, inner: Expression) -> Numbers:
        several = evaluate(events, context)
        parts = [evaluate(inner, context.within(*each.ends)) for each in several.happenings]
        if not parts:
            raise Untold("none-such")
        if len({each.unit for each in parts}) > 1:
            raise Untold("unit")
        values = np.stack([np.broadcast_to(each.values, (COUNT,)) for each in parts])
        values = np.where(several.is_so, values, np.nan)
        some = np.isfinite(values).any(axis=0)
        combined = np.full(COUNT, np.nan)
        combined[some] = combine(values[:, some])
        return parts[0].also(combined)

    return combined


def _ends(context: Context, inner: Expression) -> tuple[Numbers, Floats]:
    """Return a number and the ends of its span, (2, ..., COUNT), the same in every world."""
    numbers = evaluate(inner, context)
    values = np.broadcast_to(numbers.values, np.broadcast_shapes(numbers.values.shape, (COUNT,)))
    middle(context, values)
    ends = np.nanquantile(values, SPAN, axis=-1)
    return numbers, np.repeat(ends[..., None], COUNT, axis=-1)


def _end(place: int):
    def end(context: Context, inner: Expression) -> Numbers:
        numbers, ends = _ends(context, inner)
        return numbers.also(ends[place])

    return end


def _sigma(context: Context, inner: Expression) -> Numbers:
    numbers, (low, high) = _ends(context, inner)
    return numbers.also((high - low) / (2 * SPAN_DEVIATIONS), atom=None)


def _margin(context: Context, inner: Expression) -> Numbers:
    """Return how far what is compared lies from what it is compared with."""
    if inner.word in ("more", "less", "as-far"):
        pair = (p.of("of-first", inner.arguments[0]), p.of("of-second", inner.arguments[0]))
    elif inner.word in (">", "<", "=", "~"):
        pair = inner.arguments
    else:
        raise Untold("unit")
    return _mapped(context, np.abs, p.of("-", *pair))


def _nearest(context: Context, step: Expression, inner: Expression) -> Numbers:
    numbers = evaluate(inner, context)
    one = evaluate(step, context)
    step = np.abs((converted(context, one, numbers.unit) if one.unit else one).values)
    step = np.where(step > 0, step, np.nan)
    return numbers.also(np.round(numbers.values / step) * step)


def _mapped(context: Context, change: Callable[[Floats], Floats], inner: Expression) -> Numbers:
    numbers = evaluate(inner, context)
    return numbers.also(change(numbers.values))


def _in_unit(context: Context, unit: str, inner: Expression) -> Numbers:
    numbers = evaluate(inner, _measuring_in(context, unit))
    _, _, per = numbers.unit.partition("/")
    return converted(context, numbers, f"{unit}/{per}" if per else unit)


def _per(context: Context, per: str, inner: Expression) -> Numbers:
    numbers = evaluate(inner, context)
    top, _, clock = numbers.unit.partition("/")
    if not clock:
        raise Untold("unit")
    return converted(context, numbers, f"{top}/{per.removeprefix('per-')}")


PRIMITIVES |= {
    "#": constant,
    "in-unit": converted,
    "pi": lambda _: _number(math.pi),
    "area": _area,
    "place-x": lambda context: _number(100 * contact_middle(context)[0], "percent"),
    "place-y": lambda context: _number(100 * contact_middle(context)[1], "percent"),
    "frame-rate": _of_file("rate_hz", "frame/s"),
    "frame-width": _size("columns"),
    "frame-height": _size("rows"),
    "frame-count": _of_file("frames"),
    "chance": _chance,
    "+": _sum(1),
    "-": _sum(-1),
    "*": _times,
    "/": _over,
    "percent-of": _percent_of,
    "min": _extreme(np.minimum),
    "max": _extreme(np.maximum),
    "abs": lambda context, inner: _mapped(context, np.abs, inner),
    "negate": lambda context, inner: _mapped(context, np.negative, inner),
    "unit": _in_unit,
    "per": _per,
    "round": lambda context, _, inner: evaluate(inner, context),
    "nearest": _nearest,
    "floor": lambda context, inner: _mapped(context, np.floor, inner),
    "ceil": lambda context, inner: _mapped(context, np.ceil, inner),
    "low": _end(0),
    "high": _end(1),
    "sigma": _sigma,
    "margin": _margin,
    "mean-of": _over_events(lambda values: np.nanmean(values, axis=0)),
    "median-of": _over_events(lambda values: np.nanmedian(values, axis=0)),
    "sum-of": _over_events(lambda values: np.nansum(values, axis=0)),
    "most-of": _over_events(lambda values: np.nanmax(values, axis=0)),
    "spread-of": _over_events(lambda values: np.nanstd(values, axis=0)),
    "least-of": _over_events(lambda values: np.nanmin(values, axis=0)),
    **{count: lambda _, count=count: _number(float(count)) for count in p.COUNTS},
}
