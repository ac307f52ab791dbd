"""Detect questions that are surely not English; in doubt a text is English.

Knows a few hundred common words. Terse questions, typos and made-up names must pass.
"""

from __future__ import annotations

import re
import unicodedata

from geotlm_lm.conversation.phrases import Phrases

ENGLISH_ONLY = "I read English only; please ask in English."


_PHRASES = Phrases("english")
ENGLISH = frozenset(_PHRASES.words("ENGLISH"))
FOREIGN = frozenset(_PHRASES.words("FOREIGN")) - ENGLISH

_LETTERS = re.compile(r"[^\W\d_]+(?:['’-][^\W\d_]+)*")


def is_english(text: str) -> bool:
    """Tell whether `text` may be English.

    It is not where most letters are of another script, or where common words of other languages
    outnumber the English ones.
    """
    letters = [character for character in text if character.isalpha()]
    if not letters:
        return True
    latin = sum(unicodedata.name(letter, "").startswith("LATIN") for letter in letters)
    if latin < len(letters) / 2:
        return False
    words = [word.lower().replace("’", "'") for word in _LETTERS.findall(text)]
    foreign = sum(word in FOREIGN for word in words)
    english = sum(word in ENGLISH for word in words)
    return foreign <= english
