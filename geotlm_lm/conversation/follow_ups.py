"""Complete short follow-up questions from the one before: "and the object?", "and now?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import HOLDER
from geotlm_lm.conversation.kinds import asked_amount
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers

_PHRASES = Phrases("follow_ups")
_OF_ANOTHER = _PHRASES.pattern("OF_ANOTHER")
_NOW = _PHRASES.pattern("NOW")
_WHERE = _PHRASES.pattern("WHERE")
_ASKS = {"magnitude": "How far does {} move?", "rate": "How fast does {} move?"}


def follow_up_of(question: str, before: str | None) -> str:
    """Return a follow-up that names only what it is about as a whole question.

    "And the object?" asks of the object what was asked of the sensor: how far, how fast, or else
    which way. Of what holds the sensor it asks which way alone: it goes as
    far as the object does. Any other question stays as it is.
    """
    said = _OF_ANOTHER.fullmatch(normalised_text(question))
    if said is None:
        return question
    is_of_it = before is not None and not re.search(rf"\b{HOLDER}$", said["who"])
    kind = asked_amount(before) if is_of_it else None
    return _ASKS.get(kind, "Which way does {} move?").format(said["who"])


def asks_where(question: str) -> bool:
    """Tell whether `question` is no more than "where?"."""
    return bool(_WHERE.fullmatch(without_openers(question)))


def asks_again_now(question: str) -> bool:
    """Tell whether `question` repeats the one before as of now: "and now?"."""
    return bool(_NOW.fullmatch(normalised_text(question)))
