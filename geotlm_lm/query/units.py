"""Units: what a number is measured in, and the same number in another unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geotlm_lm.core.geometry import travel_scale
from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import (
    Context,
    Numbers,
    Untold,
    evaluate,
)
from geotlm_lm.query.program import Expression
from geotlm_lm.query.quantities import FACTORS, Quantity, in_base
from geotlm_lm.query.worlds import COUNT


def scale_of(context: Context) -> tuple[str, tuple[float, float]]:
    """Return "px" or "mm" and how many of it are a pixel of our square across and down."""
    frame, recording = context.frame, context.evidence.recording
    usual = "px" if frame.mm_per_px is None else "mm"
    wanted = context.length if context.length in ("px", "mm") else usual
    if wanted == "mm" and frame.mm_per_px is None:
        raise Untold("scale")
    size = frame.mm_per_px if wanted == "mm" else None
    _, scale = travel_scale(recording.rows, recording.columns, size)
    is_turned = context.view.rotation[0] == 0  # columns are rows then
    return wanted, scale[::-1] if is_turned else scale


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
            plain = unit.partition("/")[0]
            if plain in p.UNITS["length"]:
                return replace(context, length="px" if plain == "px" else "mm")
            if plain in p.UNITS["angle"]:
                return replace(context, length="deg")
    return context


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


# Times, spans and events


def clock_unit(context: Context) -> str:
    """Return what a recording's clock counts: seconds, or frames where its rate is not known."""
    return "s" if context.evidence.recording.rate_hz else "frame"


def clock_step(context: Context) -> float:
    """Return how long a unit of the recording's clock is on the track's own, seconds."""
    recording = context.evidence.recording
    return 1.0 if recording.rate_hz else recording.step_s or 1.0


def constant(_: Context, quantity: Quantity) -> Numbers:
    """Return a number that is stated, the same in every world, in the base of its unit."""
    value, unit, per = in_base(quantity)
    if quantity.unit.partition("/")[0] == "percent":
        unit = "percent"
    return Numbers(np.full(COUNT, value), f"{unit}/{per}" if per else unit)
