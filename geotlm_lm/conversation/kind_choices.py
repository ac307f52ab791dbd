"""Recognise choices among kinds of motion and rest: "is it slipping or stationary?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.core.labels import MotionClass

_PHRASES = Phrases("kind_choices")
REST = _PHRASES.group("REST")

_WORDS: tuple[tuple[MotionClass, str], ...] = (
    (MotionClass.ROTATION, _PHRASES.text("ROTATION")),
    (MotionClass.SLIDE, _PHRASES.text("SLIDE")),
    (MotionClass.PRESS, _PHRASES.text("PRESS")),
    (MotionClass.RELEASE, _PHRASES.text("RELEASE")),
    (MotionClass.STILL, _PHRASES.text("STILL")),
    (MotionClass.NONE, _PHRASES.text("NONE")),
)
_ONE = "|".join(f"(?:{words})" for _, words in _WORDS)
_CHOICE = Phrases("kind_choices", ONE=_ONE).pattern("CHOICE")


def offered_kinds(question: str) -> frozenset[MotionClass] | None:
    """Return the kinds of motion that `question` offers to choose from; None if none.

    Rest is one of them, and a turn or a slide another: models know choices among the others.
    """
    said = _CHOICE.fullmatch(without_openers(question))
    if said is None:
        return None
    words = re.split(r",? or (?:is it |is )?|, ", said["one"] + said["others"])
    kinds = frozenset(filter(None, map(_kind, words)))
    is_of_a_way = kinds & {MotionClass.ROTATION, MotionClass.SLIDE}
    return kinds if MotionClass.STILL in kinds and is_of_a_way else None


def _kind(word: str) -> MotionClass | None:
    word = re.sub(r"^(?:just |an? )", "", word.strip())
    return next((kind for kind, words in _WORDS if re.fullmatch(words, word)), None)
