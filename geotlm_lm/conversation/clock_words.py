"""Senses and ways told by a clock: "against the clock", "towards 3 o'clock"."""

from __future__ import annotations

import re

_CLOCK = r"(?:(?:the|a) clock(?:'?s)?(?: hands?)?|(?:the )?hands of (?:the|a) clock)"
_AT = r"(?:(?:in the direction of|towards?|to|at) )?(?:the )?"
_TOLD = tuple(
    (re.compile(rf"\b(?:{words})(?![\w-])", re.IGNORECASE), told)
    for words, told in (
        (
            rf"(?:against|counter to|contrary to|opposite to) {_CLOCK}|(?:anti|counter)-?clock"
            r"|widdershins|anti-?cw",
            "counterclockwise",
        ),
        (
            rf"(?:with|like|in the direction of|the way of) {_CLOCK}|deosil|sunwise"
            r"|(?:the way|as|like) (?:the|a) clock (?:goes|turns|runs|does)",
            "clockwise",
        ),
        (rf"follow(?:s|ed|ing)? {_CLOCK}", "go clockwise"),
        *(
            (rf"{_AT}(?:{hour}) ?o'?clock(?: (?:position|direction))?", way)
            for hour, way in (
                ("12|twelve", "up"),
                ("3|three", "right"),
                ("6|six", "down"),
                ("9|nine", "left"),
            )
        ),
    )
)


def without_clocks(text: str) -> str:
    """Return `text` with the words for directions that it tells by a clock."""
    for words, told in _TOLD:
        text = words.sub(told, text)
    return text
