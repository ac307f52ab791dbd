"""Rewrite negations without "not": "anything but a turn", "it can't be moving, can it?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("negation_wording")
_MOVES = _PHRASES.pattern("MOVES", re.IGNORECASE)
_OTHER_THAN = _PHRASES.pattern("OTHER_THAN", re.IGNORECASE)
_CANNOT = _PHRASES.pattern("CANNOT", re.IGNORECASE)
_WITHOUT = _PHRASES.pattern("WITHOUT", re.IGNORECASE)


def with_explicit_negation(question: str) -> str:
    """Replace an implicit negation by "not"; any other text stays as it is."""
    text = question.replace("\u2019", "'")
    denied = _CANNOT.sub(r"\g<who> is not \g<what>, is it", text)
    denied = _MOVES.sub(r"\g<is> \g<who> moving", denied)
    denied = _WITHOUT.sub(r"\1 but not ", _OTHER_THAN.sub(_not, denied))
    return question if denied == text else denied


def _not(said: re.Match[str]) -> str:
    verb, who = said["is"] or said["does"], said["who"] or said["whom"]
    return f"{verb} {who} not " if verb else "not "
