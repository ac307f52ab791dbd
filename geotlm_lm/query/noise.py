"""Write a text as people type: without capitals or marks, with slips of the fingers."""

from __future__ import annotations

import random
import re

_WORD = re.compile(r"[^\W\d_\ue000-\ue003]{4,}")
_KEPT = ("left", "right", "down", "turn", "clockwise", "counterclockwise", "anticlockwise")
"""Words that a slip might turn into others."""


def roughened(rng: random.Random, text: str) -> str:
    """Return a text as somebody may have typed it; marks of numbers stay whole."""
    text = text[:1].upper() + text[1:] if rng.random() < 0.6 else text
    drawn = rng.random()
    if drawn < 0.12:
        text = text.rstrip("?.")
    elif drawn < 0.16:
        text = text.lower()
    elif drawn < 0.18:
        text = text.replace("?", " ?")
    elif drawn < 0.2:
        text = text.upper()
    if rng.random() < 0.15:
        text = _with_slip(rng, text)
    return text


def _with_slip(rng: random.Random, text: str) -> str:
    """Return a text with one word misspelt: two letters swapped, one lost, doubled or changed."""
    numbers = [match.span() for match in re.finditer("\ue000.*?\ue002", text)]
    words = [
        match
        for match in _WORD.finditer(text)
        if match[0].lower() not in _KEPT
        and not any(start <= match.start() < end for start, end in numbers)
    ]
    if not words:
        return text
    match = rng.choice(words)
    word = match[0]
    at = rng.randrange(1, len(word) - 1)
    slips = (
        word[:at] + word[at + 1] + word[at] + word[at + 2 :],
        word[:at] + word[at + 1 :],
        word[:at] + word[at] + word[at:],
        word[:at] + rng.choice("aeinorst") + word[at + 1 :],
    )
    return text[: match.start()] + rng.choice(slips) + text[match.end() :]
