"""Find the numbers of a text with their units, in figures and in words.

A query copies them by place: `#2` is the second that is found.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from geotlm_lm.core.files import resource_dir
from geotlm_lm.query.program import Quantity

FACTORS = {
    "angle": {
        **{"deg": 1.0, "rad": 57.29577951308232, "mrad": 0.05729577951308232},
        **{"gon": 0.9, "turn": 360.0, "arcmin": 1 / 60},
    },
    "length": {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 0.001, "inch": 25.4, "thou": 0.0254},
    "time": {"s": 1.0, "ms": 0.001, "us": 1e-6, "min": 60.0},
}
"""How many degrees, millimetres or seconds a unit is; a pixel's and a frame's size varies."""

LARGEST = 1e12
"""Beyond every turn, length and time: a larger number is taken for this one."""

LEAST_BARE = 13
"""Number in words from which on it counts whatever follows it: "more than thirty"."""

_FIGURE = re.compile(r"[-+−]?(?:\d+(?:[.,]\d+)*|[.,]\d+)(?:\s*/\s*\d+)?")
_CLOCK = re.compile(r"(\d{1,3}):([0-5]\d(?:\.\d+)?)(?![\d:])")
_PI = re.compile(
    r"(?:(\d+(?:\.\d+)?)\s*\*?\s*)?(?:pi|π)(?![^\W\d])(?:\s*/\s*(\d+(?:\.\d+)?))?"
    r"(?:\s*rad(?:ian)?s?\b)?",
    re.IGNORECASE,
)
_BEFORE = re.compile(r"([^\W\d_]+)\s*#?$")
_WORD = re.compile(r"[^\W\d_]+\.?|[°%/\"]|[-–]")
_SPACES = re.compile(r"[\s_]*")
_PER = ("per", "/", "a", "an", "each", "every", "for", "to", "in", "the", "one")
_PER_FRAME = ("per", "/", "a", "an", "each", "every", "one")
"""The same right before a frame: "5 mm in the image" is a place."""
_RATES = ("s", "min", "frame", "px", "mm", "ms", "cm", "inch")
_ORDINAL = re.compile(r"(?:st|nd|rd|th)\b(?!\s+frames?\b)", re.IGNORECASE)
_NUMBERED = re.compile(r"(?:st|nd|rd|th)(?=\s+frames?\b)", re.IGNORECASE)
_SHORT_FRAME = re.compile(r"(?<![\w.])f$", re.IGNORECASE)
"""What stands before the number of a frame: "f30"."""


@dataclass(frozen=True)
class Stated:
    """A quantity of a text and where it stands there."""

    quantity: Quantity
    start: int
    end: int


@lru_cache(maxsize=1)
def words_of_text() -> dict[str, Any]:
    """Return the lists of words by which numbers and words to be copied are known."""
    return tomllib.loads((resource_dir("data_templates") / "query/quantities.toml").read_text())


@lru_cache(maxsize=1)
def _lexicon() -> tuple[dict[str, str], dict[str, float], dict[str, float]]:
    units_file = words_of_text()
    units = {word: unit for unit, words in units_file["units"].items() for word in words}
    return units, units_file["numbers"], units_file["fractions"]


def quantities(text: str) -> tuple[Quantity, ...]:
    """Return the quantities of a text in the order they stand in."""
    return tuple(each.quantity for each in find(text))


def find(text: str) -> list[Stated]:
    """Return the quantities of a text with their places.

    A figure counts whatever follows it, but for ordinals and names such as "B2"; a number in words
    only before a unit, before another that has one ("five to ten degrees"), or where it counts
    ("four times"). Pixels that are said to equal a length are one quantity, a scale ("20 px equal
    one millimetre").
    """
    stated: list[Stated] = []
    at = 0
    while at < len(text):
        one = _pi_at(text, at) or _figure_at(text, at) or _words_at(text, at)
        if one is None:
            step = _WORD.match(text, at) if text[at].isalpha() else None
            at = step.end() if step else at + 1
            continue
        scale = _scale(stated[-1], one, text) if stated else None
        stated[-1 if scale else len(stated) :] = [scale or one]
        at = one.end
    return [_sharing(stated, place, text) for place in range(len(stated))]


def _sharing(stated: Sequence[Stated], place: int, text: str) -> Stated:
    """Return a number with the unit that its neighbour has for both: "200 to 500 ms"."""
    own = stated[place]
    if own.quantity.unit:
        return own
    unit = ""
    if place + 1 < len(stated) and _are_joined(own, stated[place + 1], text):
        unit = stated[place + 1].quantity.unit
    elif place and _are_joined(stated[place - 1], own, text):
        before = stated[place - 1]
        is_listed = re.search(r"s\s*$", text[: before.start]) is not None  # "frames 30 to 45"
        unit = before.quantity.unit if is_listed and before.quantity.unit == "frame" else ""
    return replace(own, quantity=replace(own.quantity, unit=unit)) if "/" not in unit else own


def _are_joined(one: Stated, other: Stated, text: str) -> bool:
    between = text[one.end : other.start].strip().lower()
    return between in words_of_text()["ranges"]["words"]


def _pi_at(text: str, at: int) -> Stated | None:
    match = _PI.match(text, at)
    if match is None or (at > 0 and (text[at - 1].isalnum() or text[at - 1] in "._")):
        return None
    times, over = (float(part) if part else 1.0 for part in match.groups())
    return Stated(Quantity(math.pi * times / over, "rad"), at, match.end()) if over else None


def _scale(one: Stated, other: Stated, text: str) -> Stated | None:
    """Return the scale that two quantities are; None where they are no pixels that equal a length.

    Of "one pixel is 0.06 mm" the length alone says it: it stays a quantity of its own.
    """
    if text[one.end : other.start].strip().lower() not in words_of_text()["equals"]["words"]:
        return None
    pixels, length = one.quantity, other.quantity
    if pixels == Quantity(1.0, "px"):
        return None
    if pixels.unit != "px":
        pixels, length = length, pixels
    if pixels.unit != "px" or length.unit not in FACTORS["length"] or not length.value:
        return None
    value = _bounded(pixels.value / length.value)
    return Stated(Quantity(value, f"px/{length.unit}"), one.start, other.end)


def _figure_at(text: str, at: int) -> Stated | None:
    is_frame = _SHORT_FRAME.search(text[:at]) is not None and text[at].isdigit()
    is_inside = at > 0 and (text[at - 1].isalnum() or text[at - 1] == ".")
    if is_frame and (match := re.compile(r"\d+\b").match(text, at)):
        return Stated(Quantity(float(match[0]), "frame"), at, match.end())
    if is_inside and text[at - 2 : at] != "..":  # "2..4.5" are two
        return None
    if clock := _CLOCK.match(text, at):
        return Stated(Quantity(60 * int(clock[1]) + float(clock[2]), "s"), at, clock.end())
    match = _FIGURE.match(text, at)
    if match is None:
        return None
    if _ORDINAL.match(text, match.end()):
        return None
    figure = match[0]
    if figure[0] in "-+−" and re.search(r"[^\s(=<>:\"|[]$|\w\"$", text[max(at - 2, 0) : at]):
        return None  # a range's dash; its number is found behind it
    value, end = _value(figure), match.end()
    if value is None:  # "1/0", "0.2,0.7"
        figure = re.split(r"[/,]", figure)[0].rstrip()
        value, end = _value(figure), at + len(figure)
    if value is None:
        return None
    if _NUMBERED.match(text, end):  # "the 30th frame"
        return Stated(Quantity(value, "frame"), at, _unit_at(text, end + 2)[1])
    mixed = re.compile(r"\s+(\d+)\s*/\s*(\d+)").match(text, end)
    part = _value(f"{mixed[1]}/{mixed[2]}") if mixed and "/" not in figure else None
    if part is not None:
        value, end = value + part, mixed.end()
    unit, end = _unit_at(text, end, (*_OF, *_JOINTS) if "/" in figure or abs(value) < 1 else ())
    return Stated(Quantity(value, unit or "frame" * _follows_frame(text, at)), at, end)


def _follows_frame(text: str, at: int) -> bool:
    """Tell whether a number counts frames by the word before it: "frame 12"."""
    before = _BEFORE.search(text[max(at - 10, 0) : at])
    return before is not None and _lexicon()[0].get(before[1].lower()) == "frame"


def _value(figure: str) -> float | None:
    figure = figure.replace("−", "-").replace(" ", "")
    top, _, bottom = figure.partition("/")
    if re.fullmatch(r"[-+]?[1-9]\d{0,2}(?:,\d{3})+", top):
        top = top.replace(",", "")
    try:
        value = _bounded(float(top.replace(",", ".")))
        if bottom and not value:  # "0/1" are two
            return None
        return _bounded(value / _bounded(float(bottom))) if bottom else value
    except (ValueError, ZeroDivisionError):
        return None


def _bounded(value: float) -> float:
    return min(max(value, -LARGEST), LARGEST)


def _words_at(text: str, at: int) -> Stated | None:
    if not text[at].isalpha() or (at > 0 and (text[at - 1].isalnum() or text[at - 1] in "'’")):
        return None
    value, end = _spoken(text, at)
    if value is None:
        return None
    unit, last = _unit_at(text, end, _JOINTS if value % 1 == 0 else (*_OF, *_JOINTS))
    if _is_ordinal(text, at, end, last):
        return None
    if unit:
        return Stated(Quantity(value, unit), at, last)
    if _follows_frame(text, at):
        return Stated(Quantity(value, "frame"), at, end)
    if value >= LEAST_BARE or re.search(r"\bpoint\b", text[at:end], re.IGNORECASE):
        return Stated(Quantity(value, ""), at, end)
    if value < 2:
        return None
    joint, after = _next_word(text, end)
    if joint in words_of_text()["counted"]["words"]:
        return Stated(Quantity(value, ""), at, end)
    if joint in ("to", "and", "or"):
        figure = _figure_at(text, _SPACES.match(text, after).end())
        other, stop = _spoken(text, after)
        is_counted = _next_word(text, stop)[0] in words_of_text()["counted"]["words"]
        has_unit = is_counted or bool(_unit_at(text, stop)[0])
        if (figure and figure.quantity.unit) or (other is not None and has_unit):
            return Stated(Quantity(value, ""), at, end)
    return None


def _is_ordinal(text: str, at: int, end: int, last: int) -> bool:
    """Tell whether number words with their unit count things: "a second time", "the third turn"."""
    ordinals, unit = words_of_text()["ordinals"], text[end:last].strip()
    if unit == "second":
        return _next_word(text, last)[0] in ordinals["nouns"]
    is_share = _next_word(text, end)[0] == "of"
    return not is_share and text[at:end].lower().removeprefix("a ") in ordinals["shares"]


def _spoken(text: str, at: int) -> tuple[float | None, int]:
    """Return the value of number words from a place on, and where they end."""
    _, numbers, fractions = _lexicon()
    total, part, end, has_any = 0.0, None, at, False
    word, after = _next_word(text, at)
    while word is not None:
        if word in fractions and (part is not None or not has_any):
            scale, part = fractions[word], 1.0 if part is None else part
            total, part, has_any, end = total + part * scale, None, True, after
        elif word in ("hundred", "thousand") and part is not None:
            part, end = part * numbers[word], after
        elif word in numbers and part in range(1, 10) and 10 < numbers[word] < 100:
            if text[at : at + 2].lower() == "a ":  # "a sixty degree turn"
                break
            part, end = 100 * part + numbers[word], after  # "three sixty"
        elif word in numbers and (part is None or part >= 20 or word in ("hundred", "thousand")):
            if has_any and part is None:  # "half a turn": its "a" is the unit's
                break
            part, has_any, end = (part or 0.0) + numbers[word], True, after
        elif word == "point" and (part is not None or not has_any):  # "point oh six"
            places, behind = _digits(text, after)
            if not places:
                break
            part, has_any, end = (part or 0.0) + float(f"0.{places}"), True, behind
            word, after = _next_word(text, behind)
            continue
        elif word == "oh" and not has_any:
            part = 0.0
        elif word == "and" and has_any:
            # "one and a half" and "two hundred and five", not "ten and twenty".
            follows, behind = _next_word(text, after)
            second, last = _next_word(text, behind)
            if follows in ("a", "one", "three") and second in fractions:
                total, part = total + (part or 0.0) + numbers[follows] * fractions[second], None
                end = after = last
            elif not (part is not None and part >= 100 and follows in numbers):
                break
        elif word == "-" and part is not None:
            if part < 20 and _next_word(text, after)[0] not in fractions:  # "two-thirds"
                break
        else:
            break
        word, after = _next_word(text, after)
    return (_bounded(total + (part or 0.0)) if has_any else None), end


def _digits(text: str, at: int) -> tuple[str, int]:
    """Return spoken digits from a place on, "oh six" as "06", and where they end."""
    numbers, digits = _lexicon()[1], ""
    word, after = _next_word(text, at)
    while word == "oh" or (word in numbers and word != "a" and numbers[word] < 10):
        digits, at = digits + ("0" if word == "oh" else f"{numbers[word]:g}"), after
        word, after = _next_word(text, at)
    return digits, at


def _next_word(text: str, at: int) -> tuple[str | None, int]:
    at = _SPACES.match(text, at).end()
    match = _WORD.match(text, at)
    return (match[0].rstrip(".").lower(), match.end()) if match else (None, at)


_OF, _JOINTS = (("of", "a", "full"), ("of", "a"), ("of",)), (("a",), ("an",), ("full",), ("-",))
"""What may stand between a part and its unit, "a quarter of a turn", and between others and theirs:
"half a turn", "two full turns"."""


def _unit_at(text: str, at: int, joints: Sequence[Sequence[str]] = ()) -> tuple[str, int]:
    """Return the unit that follows a number, with what it is per, and where it ends."""
    for words in joints:
        place = at
        for expected in words:
            word, after = _next_word(text, place)
            place = after if word == expected else -1
            if place < 0:
                break
        if place >= 0 and (unit_ := _plain_unit(text, place))[0]:
            return unit_
    unit, end = _plain_unit(text, at)
    if not unit:
        return "", at
    word, after = _next_word(text, end)
    if text[end - 1] == "." and word not in ("per", "/"):  # the next sentence
        return unit, end
    for _ in range(2):  # "20 px per mm", "20 px for each mm", "20 px to the mm"
        if word not in _PER or (unit in FACTORS["time"] and word in ("in", "to")):
            break
        per, last = _plain_unit(text, after)
        nouns = words_of_text()["ordinals"]["nouns"]
        if word in ("in", "the") and per == "s" and _next_word(text, last)[0] in nouns:
            break  # "30 degrees in the second touch"
        if per in _RATES and per != unit and (per != "frame" or word in _PER_FRAME):
            return f"{unit}/{per}", last
        word, after = _next_word(text, after)
    return unit, end


def _plain_unit(text: str, at: int) -> tuple[str, int]:
    units = _lexicon()[0]
    place, words, best = at, "", ("", at)
    if text[at : at + 1] == "-" and text[at + 1 : at + 2].isalpha():  # "a 90-degree turn"
        place = at + 1
    for _ in range(3):
        word, place = _next_word(text, place)
        if word is None:
            break
        words = f"{words} {word}".strip()
        if words in units:
            best = (units[words], place)
    return best


def in_base(quantity: Quantity) -> tuple[float, str, str]:
    """Return a quantity's value in the base of its dimension, the base, and what it is per.

    Bases are deg, mm, px, s, frame and percent; speeds are per "s" or per "frame".
    """
    unit, _, per = quantity.unit.partition("/")
    value = quantity.value
    for base, factors in zip(("deg", "mm", "s"), FACTORS.values(), strict=True):
        if unit in factors:
            value, unit = value * factors[unit], base
            break
    if per in FACTORS["time"]:
        value, per = value / FACTORS["time"][per], "s"
    return value, unit, per
