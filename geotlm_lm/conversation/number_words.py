"""Parse numbers in digits and in words: "12.5", "1 1/2", "twenty-five", "half a"."""

from __future__ import annotations

import re

_BELOW_TWENTY = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"),
    *("eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen"),
    "nineteen",
)
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_TIMES = {"hundred": 100, "thousand": 1000}
_WORTH = {word: at for at, word in enumerate(_BELOW_TWENTY)} | {
    word: 10 * at for at, word in enumerate(_TENS, 2)
}
_PARTS = {"half": 1 / 2, "third": 1 / 3, "quarter": 1 / 4, "fourth": 1 / 4, "tenth": 1 / 10}

_WORD = rf"(?:{'|'.join((*sorted(_WORTH, key=len, reverse=True), *_TIMES))})\b"
_WORDS = (
    rf"(?:a (?=hundred|thousand))?\b{_WORD}"
    rf"(?:(?:(?<=hundred) and |(?<=thousand) and |[ -]){_WORD})*"
)
_PART = rf"(?:{'|'.join(_PARTS)})"

SHARE = rf"(?:an? |(?:one|two|three)[ -])?{_PART}s?\b"
"""A part of one thing: "three quarters"."""

_DIGITS = r"\d+(?:\.\d+)?|\.\d+"

NUMBER = (
    r"(?:\d+ )?\d+/\d+|\d{1,3}(?:,\d{3})+(?:\.\d+)?|\d+,\d{1,2}|\d+(?:\.\d+)?|\.\d+"
    rf"|(?:{_WORDS}|\d+) and an? {_PART}\b(?: of an?\b)?"
    rf"|{SHARE}(?: (?:of )?an?\b)?"
    rf"|{_WORDS}(?: point(?: {_WORD})+)?|a single|an?(?= )"
)
"""A number as it may be written, in lower case; "an" counts for one before a unit."""

_MIXED = re.compile(rf"(?P<whole>.+) and an? (?P<part>{_PART})(?: of an?)?")
_SHARE = re.compile(rf"(?:(?P<many>an?|one|two|three)[ -])?(?P<part>{_PART})s?(?: (?:of )?an?)?")


def number(text: str) -> float | None:
    """Return the number that `text` writes; None where its words make none, as "five ten" does."""
    if text.startswith("-"):
        below = number(text[1:])
        return None if below is None else -below
    if re.fullmatch(rf"(?:{_DIGITS})", text):
        return float(text)
    if "/" in text:
        return _fraction(text)
    if "," in text:
        is_thousands = re.fullmatch(r"\d{1,3}(?:,\d{3})+(?:\.\d+)?", text)
        return float(text.replace(",", "" if is_thousands else "."))
    if said := _MIXED.fullmatch(text):
        whole = number(said["whole"])
        return None if whole is None else whole + _PARTS[said["part"]]
    if said := _SHARE.fullmatch(text):
        return _PARTS[said["part"]] * _WORTH.get(said["many"], 1)
    whole, _, decimals = text.partition(" point ")
    value = _in_words(whole)
    for place, digit in enumerate(decimals.split(), 1):
        if value is None or _WORTH.get(digit, 10) > 9:
            return None
        value += _WORTH[digit] / 10**place
    return value


def _fraction(text: str) -> float | None:
    *whole, fraction = text.split(" ")
    above, below = map(float, fraction.split("/"))
    return None if not below else sum(map(float, whole)) + above / below


def _in_words(text: str) -> float | None:
    """Return the number of words such as "two hundred and five", or "a" for one."""
    if text in ("a", "an", "a single"):
        return 1.0
    total = group = 0
    last = 1000
    for word in re.split(r"[ -]", text.removeprefix("a ").replace(" and ", " ")):
        if word in _TIMES:
            group = max(group, 1) * _TIMES[word]
            if word == "thousand":
                total, group = total + group, 0
            last = _TIMES[word]
        elif _WORTH[word] < 10 and last in range(20, 100, 10) or last >= 100:
            group, last = group + _WORTH[word], _WORTH[word]
        else:
            return None
    return float(total + group)
