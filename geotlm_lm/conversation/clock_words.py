"""Translate clock directions into directions: "against the clock", "towards 3 o'clock"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("clock_words")
_SENSES = tuple(
    (re.compile(rf"\b(?:{words})(?![\w-])", re.IGNORECASE), told)
    for words, told in (
        (_PHRASES.text("AGAINST_THE_CLOCK"), "counterclockwise"),
        (_PHRASES.text("WITH_THE_CLOCK"), "clockwise"),
        (_PHRASES.text("FOLLOWS_THE_CLOCK"), "go clockwise"),
    )
)
_TO = _PHRASES.text("TO")
_AT = _PHRASES.text("AT")
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
        (_PHRASES.text("TWELVE"), "up"),
        (_PHRASES.text("THREE"), "right"),
        (_PHRASES.text("SIX"), "down"),
        (_PHRASES.text("NINE"), "left"),
    )
)
_FROM_TO = _PHRASES.pattern("FROM_TO", re.IGNORECASE)


def without_clocks(text: str) -> str:
    """Replace clock directions in `text` by the words for directions.

    From one hour to another is an arc, or a span of time, and "at 9 o'clock" a time of day.
    """
    told_by = _SENSES if _FROM_TO.search(text) else _SENSES + _HOURS
    for words, told in told_by:
        text = words.sub(told, text)
    return text
