"""Parse numbers with a unit: "12 px", "half a turn", "twenty to thirty degrees".

Knows no question: what a number is said of is read elsewhere.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from geotlm_lm.conversation.number_words import NUMBER, SHARE, number
from geotlm_lm.conversation.phrases import Phrases

_WORDS = Phrases("quantities")


TURN_DEG = 360.0
_TURNS = _WORDS.text("TURNS")

UNITS: tuple[tuple[str, str, float], ...] = (
    (_WORDS.text("DEGREES"), "deg", 1.0),
    (_WORDS.text("RADIANS"), "deg", math.degrees(1.0)),
    (_WORDS.text("ARC_MINUTES"), "deg", 1 / 60),
    (_WORDS.text("ARC_SECONDS"), "deg", 1 / 3600),
    (_WORDS.text("PIXELS"), "px", 1.0),
    (_WORDS.text("MILLIMETRES"), "mm", 1.0),
    (_WORDS.text("CENTIMETRES"), "mm", 10.0),
    (_WORDS.text("METRES"), "mm", 1e3),
    (_WORDS.text("MICROMETRES"), "mm", 1e-3),
    (_WORDS.text("INCHES"), "mm", 25.4),
    (_WORDS.text("RPM"), "deg/s", TURN_DEG / 60),
    (_WORDS.text("RPS"), "deg/s", TURN_DEG),
    (_WORDS.text("WHOLE_TURNS"), "deg", TURN_DEG),
)
"""What a unit is called, the unit it is told in, and how much of that one is."""

UNIT = "|".join(f"(?:{words})" for words, _, _ in UNITS)
SECONDS: tuple[tuple[str, float], ...] = (
    (_WORDS.text("SECONDS"), 1.0),
    (_WORDS.text("MINUTES"), 60.0),
    (_WORDS.text("HOURS"), 3600.0),
)

_PHRASES = Phrases("quantities", NUMBER=NUMBER, SHARE=SHARE, UNIT=UNIT)
_QUANTITY = _PHRASES.pattern("QUANTITY")
_PART_OF_A_TURN = _PHRASES.pattern("PART_OF_A_TURN")
_OR_A_KIND = _PHRASES.pattern("OR_A_KIND")
_A_KIND_OR = _PHRASES.pattern("A_KIND_OR")
_OF_A_THING = _PHRASES.pattern("OF_A_THING")
_THING = _PHRASES.pattern("THING")


@dataclass(frozen=True)
class Quantity:
    """A number with a unit in a text.

    Args:
        start: Where it begins.
        end: Where it ends.
        values: In `unit`: one, or both ends of a range; none where it cannot be read.
        unit: "deg", "px" or "mm"; "deg/s" and so on of a speed.
    """

    start: int
    end: int
    values: tuple[float, ...]
    unit: str


def quantities(text: str) -> tuple[Quantity, ...]:
    """Return the numbers with a unit in `text`, lower case; not the size of "a 10 mm nut"."""
    return tuple(_found(text))


def without_quantities(text: str) -> str:
    """Return `text`, lower case, without its numbers with a unit."""
    for found in reversed(quantities(text)):
        text = f"{text[: found.start]} {text[found.end :]}"
    return text


def _found(text: str) -> Iterator[Quantity]:
    ends = 0
    for said in sorted(_said(text), key=lambda said: (said.start(), -said.end())):
        if said.start() < ends or _names_a_motion(said, text):
            continue
        ends = said.end()
        if said.re is _PART_OF_A_TURN:
            yield Quantity(*said.span(), (_part_of_a_turn(said),), "deg")
        elif not (_OF_A_THING.search(text[: said.start()]) and _THING.match(text[ends:])):
            yield _read(said, text)


def _names_a_motion(said: re.Match[str], text: str) -> bool:
    """Tell whether nothing is counted: "is it a rotation?", "is it one rotation or a slide?"."""
    named = said.groupdict()
    if named.get("time") or not re.fullmatch(_TURNS, named.get("unit") or ""):
        return False
    is_offered = _OR_A_KIND.match(text[said.end() :]) or _A_KIND_OR.search(text[: said.start()])
    return named["number"] in ("a", "an") or (named["number"] == "one" and bool(is_offered))


def _said(text: str) -> Iterator[re.Match[str]]:
    yield from _QUANTITY.finditer(text)
    yield from _PART_OF_A_TURN.finditer(text)


def _part_of_a_turn(said: re.Match[str]) -> float:
    return TURN_DEG * ((said["share"] and number(said["share"])) or 1.0)


def _read(said: re.Match[str], text: str) -> Quantity:
    unit, factor = unit_of(_plural(said["unit"]))
    if said["time"] is not None:
        each = [s for words, s in SECONDS if re.fullmatch(words, said["time"])]
        unit, factor = f"{unit}/s", factor / each[0] if each else math.nan
    high = number(said["number"]) if said["number"] else None
    values: tuple[float | None, ...] = (high,)
    if said["low"] is not None:
        values = _ends(said, number(said["low"]), high, factor, text)
    told = tuple(value * factor for value in values if value is not None)
    is_read = len(told) == len(values) and all(0 <= value < math.inf for value in told)
    is_rising = told == tuple(sorted(told))
    return Quantity(*said.span(), told if is_read and is_rising else (), unit)


def _ends(
    said: re.Match[str], low: float | None, high: float | None, factor: float, text: str
) -> tuple[float | None, ...]:
    """Return both ends of a range, in the unit of its last number; (None,) where it is none."""
    join, unit = said["join"], unit_of(_plural(said["unit"]))[0]
    if join == "and" and not text[: said.start()].endswith("between "):
        return (number(f"{said['low']} and {said['number']}"),)  # "one and a half", or None
    if low is None or high is None or join == "or":
        return (None,)
    if join in ("\u00b1", "+-", "+/-", "plus or minus"):
        return (low - high, low + high)
    if said["first"] is not None:
        first, of_one = unit_of(said["first"])
        return (low * of_one / factor, high) if first == unit else (None,)
    return (low, high)


def _plural(unit: str) -> str:
    return f"{unit}s" if unit.endswith(("turn", "circle")) else unit


def unit_of(words: str) -> tuple[str, float]:
    """Return the unit that `words` are told in, and how much of it one of theirs is.

    Raises:
        StopIteration: If `words` name no unit.
    """
    return next((unit, factor) for name, unit, factor in UNITS if re.fullmatch(name, words))
