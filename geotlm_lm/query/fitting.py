"""Which numbers of a question may stand where: a scale is a length, a span a time."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from geotlm_lm.core.twist import COMPONENT_OF, Component
from geotlm_lm.query import types as t
from geotlm_lm.query.types import Quantity

_NO_UNIT = ("", "percent")
_UNITS = {
    "scale": (*t.UNITS["length"], ""),
    "view": (*t.UNITS["length"], ""),
    "from": (*t.UNITS["time"], *_NO_UNIT),
    "to": (*t.UNITS["time"], *_NO_UNIT),
}
"""Units of the number behind a word."""

_OF_COMPONENT = {
    Component.TURN: (*t.UNITS["angle"], *_NO_UNIT),
    Component.SLIDE: (*t.UNITS["length"], *_NO_UNIT),
    Component.PRESS: (*t.UNITS["length"], *_NO_UNIT),
}
_RELATIONS = (">", "<", "~", "in-range")


def fitting(
    prefix: Sequence[str], allowed: Collection[str], quantities: Sequence[Quantity]
) -> set[str]:
    """Return the next words of a query without those whose number cannot be meant there.

    Args:
        prefix: Words so far.
        allowed: Words that may follow by form.
        quantities: Of the question, as slots count them.
    """
    found = set(allowed)
    if prefix and prefix[-1] == "fact":
        is_length = any(_fits(one, _UNITS["scale"]) for one in quantities)
        return found if is_length else found - {"scale", "view"}
    units = _units(prefix)
    slots = {word for word in found if word.startswith("#")}
    if units is None or not slots:
        return found
    fit = {word for word in slots if _fits(quantities[int(word[1:]) - 1], units)}
    return (found - slots) | (fit or slots)


def _units(prefix: Sequence[str]) -> tuple[str, ...] | None:
    """Return the units that the next number may have; None where any will do."""
    words = list(prefix)
    while words and words[-1].startswith("#"):  # the second end of a range
        words.pop()
    if not words or words[-1] in _UNITS:
        return _UNITS[words[-1]] if words else None
    if words[-1] not in _RELATIONS or len(words) < 2:
        return None
    atom = words[-2]
    component = t.COMPONENT_ATOMS.get(atom) or COMPONENT_OF.get(t.WAY_ATOMS.get(atom))
    return t.UNITS["length"] + _NO_UNIT if atom in ("x", "y") else _OF_COMPONENT.get(component)


def _fits(quantity: Quantity, units: Sequence[str]) -> bool:
    top, _, per = quantity.unit.partition("/")
    # Of "1 px = 0.04 mm" the pixel is no size; of "20 px per mm" it is a part.
    is_bare_pixel = units is _UNITS["scale"] and quantity.unit == "px"
    is_part = units is _UNITS["scale"] and per != "" and per in units
    return not is_bare_pixel and (top in units or is_part)
