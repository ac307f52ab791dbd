"""Facts on the set-up: what can be stated, and what they make of a `FrameSpec`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query.quantities import FACTORS, Quantity
from geotlm_lm.query.types import Fact
from geotlm_lm.query.words import Words, number_word

FACTS: dict[str, tuple[tuple[str, ...], int]] = {
    "mirrored": ((), 0),
    "turned": (("half", "quarter-cw", "quarter-ccw"), 0),
    "seen": (("sensor", "object"), 0),
    "moves": (("sensor", "object"), 0),
    "thread": (("left", "right"), 0),
    "side": (("head", "shank", "side"), 0),
    "scale": ((), 1),
    "view": ((), 1),
    "rate": ((), 1),
    "everything": ((), 0),
    "unclear": (("turned", "mirrored", "thread", "side", "other"), 0),
}
"""Name of a fact -> its settings and how many quantities it has.

"turned" is how the recorded image is; "scale" mm per pixel or pixels per mm, "view" the width that
the frames show, "rate" frames per second; "unclear" is one that was not
understood."""

_FIELD = {"seen": "viewpoint", "moves": "actor", "thread": "thread", "side": "contact_side"}
_PLAIN = FrameSpec()


def write_fact(fact: Fact) -> list[str]:
    """Return a fact as its words."""
    value = [] if fact.value is None else [fact.value]
    return ["fact", *["not"] * fact.denied, fact.name, *value, *map(number_word, fact.numbers)]


def read_fact(words: Words) -> Fact:
    """Read the words of a fact behind "fact".

    Raises:
        Malformed: If they are none.
    """
    denied = words.optional("not") is not None
    has_numbers = words.slots or any(":" in word for word in words.words)
    names = [name for name, (_, count) in FACTS.items() if has_numbers or not count or denied]
    name = words.take(*names)
    values, count = FACTS[name]
    value = words.optional(*values) if denied else words.take(*values) if values else None
    numbers = () if denied else tuple(words.number() for _ in range(count))
    return Fact(name, value, numbers, denied)


def with_facts(frame: FrameSpec, facts: tuple[Any, ...], columns: int) -> FrameSpec:
    """Return a frame in which some facts hold, in turn.

    Args:
        frame: What held before.
        facts: Filled ones.
        columns: Width of the recording's frames, by which "view" tells the size of a pixel.

    Raises:
        UsageError: If a pixel would be of a size, or frames of a rate, that no camera has.
    """
    for fact in facts:
        frame = replace(frame, **_fields(frame, fact, columns))
    return frame


def _fields(frame: FrameSpec, fact: Any, columns: int) -> dict[str, Any]:
    if fact.name == "everything":
        return vars(_PLAIN)
    if fact.name == "mirrored":
        return {"image_mirrored": not fact.denied}
    if fact.name == "turned":
        degrees = {"half": 180, "quarter-cw": 90, "quarter-ccw": 270}.get(fact.value, 0)
        return FrameSpec.fields_of_turn(0 if fact.denied else degrees)
    if fact.name in _FIELD:
        name = _FIELD[fact.name]
        return {name: getattr(_PLAIN, name) if fact.denied else fact.value}
    if fact.name in ("scale", "view"):
        across = columns if fact.name == "view" else 1
        return {"mm_per_px": None if fact.denied else mm_per_px(fact.numbers[0], across)}
    if fact.name == "rate":
        return {"rate_hz": None if fact.denied else _rate_hz(fact.numbers[0])}
    return {}


def _rate_hz(rate: Quantity) -> float | None:
    """Return frames per second, of a bare number too; None where the quantity is no rate."""
    unit, _, per = rate.unit.partition("/")
    if not rate.unit:
        return rate.value
    second = FACTORS["time"].get(per)
    return rate.value / second if unit == "frame" and second else None


def mm_per_px(size: Quantity, pixels: int = 1) -> float | None:
    """Return the size of a pixel, mm, where so many measure "60 um", or of "20 px/mm".

    A bare number is in mm; None where the quantity is no length.
    """
    unit, _, per = size.unit.partition("/")
    unit = unit or "mm"
    if unit == "px" and per in FACTORS["length"]:
        return FACTORS["length"][per] / size.value if size.value else None
    factor = FACTORS["length"].get(unit)
    return None if factor is None else size.value * factor / pixels
