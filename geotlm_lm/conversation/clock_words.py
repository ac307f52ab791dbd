"""Translate clock directions into directions: "against the clock", "towards 3 o'clock"."""

from __future__ import annotations

import re

_CLOCK = r"(?:(?:the|a) clock(?:'?s)?(?: hands?)?|(?:the )?hands of (?:the|a) clock)"
_SENSES = tuple(
    (re.compile(rf"\b(?:{words})(?![\w-])", re.IGNORECASE), told)
    for words, told in (
        (
            rf"(?:against|unlike|counter to|contrary to|opposite to) {_CLOCK}"
            r"|(?:anti|counter)-?clock|widdershins|anti-?cw",
            "counterclockwise",
        ),
        (
            rf"(?:with|like|in the direction of|the way of) {_CLOCK}|deosil|sunwise"
            r"|(?:the way|as|like) (?:the|a) clock (?:goes|turns|runs|does)",
            "clockwise",
        ),
        (rf"follow(?:s|ed|ing)? {_CLOCK}", "go clockwise"),
    )
)
_TO = r"(?:in the direction of|towards?|to) (?:the )?"
_AT = r"(?:(?:at|in) )?(?:the )?"
_HOURS = tuple(
    (
        re.compile(
            rf"\b(?:{_TO}{hour}(?: (?:position|direction))?|{_AT}{hour} (?:position|direction)"
            rf"|^(?:at )?{hour}(?=\W*$))(?![\w-])",
            re.IGNORECASE,
        ),
        way,
    )
    for hour, way in (
        (r"(?:12|twelve) ?o'?clock", "up"),
        (r"(?:3|three) ?o'?clock", "right"),
        (r"(?:6|six) ?o'?clock", "down"),
        (r"(?:9|nine) ?o'?clock", "left"),
    )
)
_FROM_TO = re.compile(r"\bfrom (?:the )?\w+(?: ?o'?clock)? (?:to|until|till)\b", re.IGNORECASE)


def without_clocks(text: str) -> str:
    """Replace clock directions in `text` by the words for directions.

    From one hour to another is an arc, or a span of time, and "at 9 o'clock" a time of day.
    """
    told_by = _SENSES if _FROM_TO.search(text) else _SENSES + _HOURS
    for words, told in told_by:
        text = words.sub(told, text)
    return text
