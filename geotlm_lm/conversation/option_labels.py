"""Parse the labels of a multiple choice, and the words of each option."""

from __future__ import annotations

import re
from collections.abc import Callable

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("option_labels")
_LETTER = _PHRASES.group("LETTER")
_LISTED = _PHRASES.group("LISTED")
_BEFORE, _ALSO_BEFORE = (
    re.compile(rf"\(?({label})[).:=]\s*(.*?)(?=[,;]?\s*\(?{label}|$)")
    for label in (_LETTER, _LISTED)
)
_STANDS_FOR = _PHRASES.pattern("STANDS_FOR")
_SAID_IF = _PHRASES.pattern("SAID_IF")
_SAID_ELSE = _PHRASES.pattern("SAID_ELSE")
_BEHIND = re.compile(r"([^()]*)\(([A-F1-6])\)")
_TAIL = _PHRASES.pattern("TAIL", re.IGNORECASE)

Labelled = list[tuple[str, str]]


def labelled(text: str, says: Callable[[str], bool]) -> Labelled:
    """Return every label of a multiple choice with the words of its option.

    Labels stand before their options, "A) left", "1. left" or "A for left", or behind them, "left
    (A)" or "if left say A": they are read the way in which more options say something, before where
    both say as much.

    Args:
        text: In upper case.
        says: Tells whether the words of an option are understood.
    """
    before = _BEFORE.findall(text)
    before = max(before, _in_sequence(_ALSO_BEFORE.findall(text)), key=len)
    before = max(before, _STANDS_FOR.findall(text), key=len)
    behind = [(label, option) for option, label in _BEHIND.findall(text)]
    if not behind and (said_if := _SAID_IF.findall(text)):
        behind = [(label, option) for option, label in said_if + _SAID_ELSE.findall(text)]

    def understood(found: Labelled) -> int:
        return sum(says(option) for _, option in found)

    return behind if understood(behind) > understood(before) else before


def _in_sequence(found: Labelled) -> Labelled:
    """Return labels that count up from 1 or A; none where they do not: "at 2. Which way?"."""
    order = "".join(label for label, _ in found)
    return (
        found
        if len(order) > 1 and order in ("123456"[: len(order)], "ABCDEF"[: len(order)])
        else []
    )


def without_tail(option: str) -> str:
    """Strip what is asked behind an option: "up. Which letter?"."""
    return _TAIL.sub("", option).strip(" ,;")
