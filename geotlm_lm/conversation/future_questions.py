"""Recognise questions about future motion, which no recording shows: "will it slip?"."""

from __future__ import annotations

from geotlm_lm.conversation.object_names import with_generic_objects
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("future_questions")
NO_PREDICTION = (
    "I tell what the clip shows, not what comes next; ask for example 'is it slipping?' or 'which "
    "way does it turn?'."
)

_ASKED = _PHRASES.pattern("ASKED")


def asks_future_motion(question: str) -> bool:
    """Tell whether a whole text asks how something will move; nothing supposed before it."""
    return any(map(_ASKED.fullmatch, with_generic_objects(without_openers(question))))
