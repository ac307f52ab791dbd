"""Correct mistyped words for kinds of motion, before any other rule reads them."""

from __future__ import annotations

import re
from difflib import get_close_matches

_MEANT = (
    "slipping",
    "sliding",
    "turning",
    "rotating",
    "twisting",
    "spinning",
    "touching",
    "moving",
    "clockwise",
    "counterclockwise",
    "anticlockwise",
)

_SHORT = ("left", "right", "down", "still", "slip", "slide", "turn", "move", "touch", "press")
"""Words so short that many others are as near: only two letters exchanged, or one twice, count."""

_OTHERS = re.compile(
    r"burning|clipping|dripping|eliding|flipping|gliding|lipping|listing|loving|pinning|proving"
    r"|rating|resting|returning|ripping|rotation|roving|shipping|siding|sinning|sipping|skidding"
    r"|couching|rotting|slicing|slopping|skipping|slapping|snipping|spanning|thinning|tipping|touring|tuning|turing"
)
"""English words as near to one of these."""

_JOINED = re.compile(r"(?<=[^\W_])_+(?=[^\W_])")
_IS = r"^(\W*(?:is|was|has|did))"
_JUST = r"(?:(?:not|still|now|just|really|already) )?"
_NO_NAME = r"(?!(?:it|the|this|that|my|there|any|anything|something)\b)"
_IS_DOING = re.compile(
    rf"{_IS} (?!it\b|the\b|any)(?={_JUST}\w+(?:ing|ed)\b|{_JUST}\w+$)", re.IGNORECASE
)
_NAMED_DOING = re.compile(rf"{_IS} (?={_NO_NAME}\w+ {_JUST}\w+(?:ing|ed)\b)", re.IGNORECASE)
_CAMEL_CASE = re.compile(r"\W*(?:is|was|has|did)[A-Z][A-Za-z]+(?:\(\))?\W*")
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
