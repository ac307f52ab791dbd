"""Which numbers of a question may stand where: beside an angle stands one, a span is a time."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.core.twist import Component
from geotlm_lm.query.evaluate import COMPONENT
from geotlm_lm.query.lines import begun
from geotlm_lm.query.program import OVER_EVENTS, UNITS, Expression
from geotlm_lm.query.types import Quantity

_ANY = ("", "percent")
_TIMES = (*UNITS["time"], *_ANY)
_LENGTHS = (*UNITS["length"], *_ANY)

_TIMED = ("length", "lasts", "time-while", "delay", "clock")
_SHARES = ("share", "percent-of", "area", "chance", "place-x", "place-y")
_FACTS = {"scale": (*UNITS["length"], ""), "view": (*UNITS["length"], "")}
_AROUND = ("within", "at", "abs", "negate", "round", "nearest", "low", "high", "sigma",
           "floor", "ceil")  # fmt: skip
_OF_TIME = ("t", "initial", "final", "later", "earlier", "around")


def fitting(prefix: Sequence[str], quantities: Sequence[Quantity], texts: int = 0) -> set[str]:
    """Return the next words of a program without those whose number cannot be meant there.

    Args:
        prefix: Words so far.
        quantities: Of the question, as slots count them.
        texts: How many of its words may be copied.
    """
    allowed, open_ = begun(prefix, len(quantities), texts)
    words = set(allowed)
    if prefix and prefix[-1] == "fact":
        is_length = any(_fits(each, _FACTS["scale"]) for each in quantities)
        return words if is_length else words - _FACTS.keys()
    units = _FACTS.get(prefix[-1]) if prefix else None
    if units is None and open_ is not None:
        units = _wanted(*open_)
    slots = {word for word in words if word.startswith("#")}
    if units is None or not slots:
        return words
    fit = {word for word in slots if _fits(quantities[int(word[1:]) - 1], units)}
    return (words - slots) | (fit or slots)


def _wanted(word: str, arguments: Sequence[Expression]) -> tuple[str, ...] | None:
    """Return the units that the next number of a primitive may have; None where any will do."""
    if word in _OF_TIME:
        return _TIMES
    if word not in (">", "<", "=", "~", "in-range", "+", "-", "percent-of") or not arguments:
        return None
    return _units_of(arguments[0])


def _units_of(measured: Expression) -> tuple[str, ...] | None:
    """Return the units of a measure; None where they are not known or those of a speed."""
    while measured.word in (*_AROUND, *OVER_EVENTS):
        measured = measured.arguments[-1]
    if measured.word == "unit":
        kind = next(units for units in UNITS.values() if measured.arguments[0] in units)
        return (*kind, *_ANY)
    if measured.word in _TIMED:
        return _TIMES
    if measured.word in _SHARES:
        return _ANY
    if measured.word == "count":
        return ("", "turn")  # "three turns"
    if measured.word not in ("amount", "net", "path", "peak", "limit"):
        return None
    component = COMPONENT.get(measured.arguments[0])
    if component is None:
        return None
    return (*UNITS["angle"], *_ANY) if component is Component.TURN else _LENGTHS


def _fits(quantity: Quantity, units: Sequence[str]) -> bool:
    top, _, per = quantity.unit.partition("/")
    # Of "1 px = 0.04 mm" the pixel is no size; of "20 px per mm" it is a part.
    is_size = units is _FACTS["scale"]
    is_part = is_size and per != "" and per in units
    return not (is_size and quantity.unit == "px") and (top in units or is_part)
