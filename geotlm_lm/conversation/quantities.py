"""Parse numbers with a unit: "12 px", "half a turn", "twenty to thirty degrees".

Knows no question: what a number is said of is read elsewhere.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from geotlm_lm.conversation.number_words import NUMBER, SHARE, number

TURN_DEG = 360.0
_TURNS = r"(?:turns|revolutions?|rotations?|circles|revs?)\b"

UNITS: tuple[tuple[str, str, float], ...] = (
    (r"(?:degrees?|degs?)\b|\u00b0", "deg", 1.0),
    (r"(?:radians?|rads?)\b", "deg", math.degrees(1.0)),
    (r"(?:arc ?min(?:ute)?s?|minutes? of arc)\b", "deg", 1 / 60),
    (r"(?:arc ?sec(?:ond)?s?|seconds? of arc)\b", "deg", 1 / 3600),
    (r"(?:px|pixels?)\b", "px", 1.0),
    (r"(?:mm|millimet(?:er|re)s?)\b", "mm", 1.0),
    (r"(?:cm|centimet(?:er|re)s?)\b", "mm", 10.0),
    (r"(?:m|met(?:er|re)s?)\b", "mm", 1e3),
    (r"(?:[u\u00b5\u03bc]m|microns?|micromet(?:er|re)s?)\b", "mm", 1e-3),
    (r"inch(?:es)?\b", "mm", 25.4),
    (r"rpm\b", "deg/s", TURN_DEG / 60),
    (r"rps\b", "deg/s", TURN_DEG),
    (rf"(?:full |whole |complete |entire )?{_TURNS}", "deg", TURN_DEG),
)
"""What a unit is called, the unit it is told in, and how much of that one is."""

UNIT = "|".join(f"(?:{words})" for words, _, _ in UNITS)
SECONDS: tuple[tuple[str, float], ...] = (
    (r"(?:s|secs?|seconds?)\b", 1.0),
    (r"(?:min|minutes?)\b", 60.0),
    (r"(?:h|hours?)\b", 3600.0),
)
_EACH = r"(?: ?/ ?| per | an? | each | every | in (?:a|one) )"
_TIME = r"(?:s|secs?|seconds?|min|minutes?|h|hours?|frames?|pixels?|px)\b"
PER = rf"{_EACH}(?P<time>{_TIME})"
_ONE_TURN = rf"(?:full |whole |complete |entire )?(?:turn|circle)(?={_EACH}{_TIME})"
"""A turn is a unit by itself only of a speed: "does one turn left?" counts nothing."""

_JOIN = (
    r" ?(?P<join>-|\u2013|\bto\b|\band\b|\bor\b|\u00b1|\+/?-|\bplus or minus\b"
    r"|\b(?:but|and) (?:less than|fewer than|under|below|at most)\b) ?"
)
_STANDS_ALONE = r"(?<![\w.,/-])"
_SOME = r"(?:a few|a couple of|several|some|many|a lot of|(?:ten|dozen|hundred)s of|(?:\w+ )?pi)"

_QUANTITY = re.compile(
    rf"{_STANDS_ALONE}(?:(?:(?P<low>{NUMBER})(?: ?-?(?P<first>{UNIT}))?{_JOIN})?"
    rf"(?P<number>-?(?:{NUMBER}))|(?P<vague>{_SOME})) ?-?(?P<unit>{UNIT}|{_ONE_TURN})(?:{PER})?"
)
_PART_OF_A_TURN = re.compile(
    rf"\b(?:(?P<share>{SHARE}) |(?:(?:one|a|the) )?(?:full|whole|complete|entire) )"
    r"(?:of (?:a |one )?|a |one )?(?:turn|revolution|rotation|circle)\b"
    r"|(?:(?<=than )|(?<=least )|(?<=most ))(?:one|an?) (?:turn|revolution|rotation|circle)\b"
    r"|(?:(?<=made )|(?<=make )|(?<=about )|(?<=by ))one turn\b|\ball the way (?:a)?round\b"
)
_A_KIND = r"(?:(?:just|only|one|an?|simple|pure) )*(?:slide|slip|translation|press|push|shift|drag)"
_OR_A_KIND = re.compile(rf" or {_A_KIND}")
_A_KIND_OR = re.compile(rf"\b{_A_KIND},? or (?:just |only )?$")
_OF_A_THING = re.compile(
    r"^(?!.*\b(?:is|was) (?:it|this|that|(?:the|my) \w+) an? $)"  # there the size is claimed
    r".*\b(?:the|this|that|an?|my|your)(?: \w+)?"
    r"(?: [\d.]+ ?(?:[uc\u00b5]?m|mm)? ?(?:x|by|\u00d7))? $"
)
MOTION_NOUN = (
    r"(?:turns?|rotation|twist|spin|slide|slip|shift|move|motion|movement|displacement|drift"
    r"|in|to|towards?|or|and|but|per|at|by|on|of|over|within|during|from|max|tops|clock\w*|counter"
    r"|anti|c?cw|left|right|up|down|please|then|so|not|apart|further|farther|altogether|total)"
)
"""What an amount may stand before and still be of a motion."""

_THING = re.compile(rf" (?!{MOTION_NOUN}\w*\b)[a-z]")


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
