"""Correct mistyped words for kinds of motion, before any other rule reads them."""

from __future__ import annotations

import re
from difflib import get_close_matches

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("spelling")
_MEANT = _PHRASES.words("MEANT")
_SHORT = _PHRASES.words("SHORT")
_OTHERS = _PHRASES.pattern("OTHERS")

_JOINED = re.compile(r"(?<=[^\W_])_+(?=[^\W_])")
_IS_DOING = _PHRASES.pattern("IS_DOING", re.IGNORECASE)
_NAMED_DOING = _PHRASES.pattern("NAMED_DOING", re.IGNORECASE)
_CAMEL_CASE = _PHRASES.pattern("CAMEL_CASE")
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
_UNEQUAL = re.compile(r"\s*(?:!==?|\u2260|<>)\s*")

_ALIKE = 0.85
"""Similarity of "slipping" and "sliping": 0.93; of "turning" and "truning": 0.86."""


def _slips_of(word: str) -> set[str]:
    """Return `word` with each two neighbouring letters exchanged and with each letter twice."""
    ends = range(1, len(word))
    exchanged = {word[: at - 1] + word[at] + word[at - 1] + word[at + 1 :] for at in ends}
    twice = {word[:at] + word[at - 1 :] for at in range(1, len(word) + 1)}
    return exchanged | twice - {word}


_MEANT_BY = {slip: word for word in _SHORT for slip in _slips_of(word) if slip not in _SHORT}


def corrected_spelling(question: str) -> str:
    """Correct the mistyped ones of a few words.

    Only what a model or a rule takes for another question is worth it: asked whether something is
    "sliping", the model says that something touches.
    """
    return re.sub(r"[A-Za-z]{4,}", lambda word: _meant(word[0]), question)


def split_code_words(question: str) -> str:
    """Split identifiers into words: "slip_direction", "isTurning()"."""
    apart = _JOINED.sub(" ", _UNEQUAL.sub(" is not ", question))
    if _CAMEL_CASE.fullmatch(question):
        apart = _HUMP.sub(" ", question).replace("()", "").lower()
    if apart == question:
        return question
    return _NAMED_DOING.sub(r"\1 the ", _IS_DOING.sub(r"\1 it ", apart))


def _meant(word: str) -> str:
    lower = word.lower()
    if lower in _MEANT_BY or len(word) < 6:
        return _MEANT_BY.get(lower, word)
    # "unmoving" and "removing" are words of their own.
    if lower.endswith(_MEANT) or _OTHERS.fullmatch(lower):
        return word
    return next(iter(get_close_matches(lower, _MEANT, 1, _ALIKE)), word)
