"""Recognise questions to which "something is touching" or "it is moving" is an answer.

A model that reads words it does not know says one of the two, however sure: of a crack, of dust, of
itself. Of a definite thing ("is the cable mine?") only a verb that names no motion tells so.
"""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("existence_questions")
_THERE = _PHRASES.pattern("THERE")
_OF_CONTACT = _PHRASES.pattern("OF_CONTACT")
_IS_THERE_CONTACT = _PHRASES.pattern("IS_THERE_CONTACT")
_OF_MOTION = _PHRASES.pattern("OF_MOTION")
_DEFINITE = _PHRASES.pattern("DEFINITE")
_DOING = _PHRASES.pattern("DOING")


def speaks_of_motion(text: str) -> bool:
    """Tell whether `text` has any word for a motion, a direction or rest."""
    return bool(_OF_MOTION.search(text.lower()))


def is_unasked_existence(kind: str | None, question: str) -> bool:
    """Tell whether an answer "touching" or "moving" meets a question that asks neither.

    Args:
        kind: Of the model's answer.
        question: What was asked.
    """
    text = normalised_text(question)
    if kind not in ("contact", "moving"):
        return False
    there = _THERE.search(text)
    if kind == "contact" and there is not None:
        return not _IS_THERE_CONTACT.search(there["what"])
    if (_OF_CONTACT if kind == "contact" else _OF_MOTION).search(text):
        return False
    return not _DEFINITE.search(text) or (kind == "moving" and bool(_DOING.search(text)))
