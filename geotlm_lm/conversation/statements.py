"""Detect statements about the recording in which no fact could be read."""

from __future__ import annotations

from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("statements")
UNREAD = (
    "I read no fact about the recording in that; say for example 'left-hand thread', 'the image is "
    "mirrored' or 'I look from the object's side'."
)

TURN_TOLD_AFTER = (
    "What was said of the image after the question is not counted in; tell it before the question."
)

_STATEMENT = _PHRASES.pattern("STATEMENT")
_OF_A_FRAME = _PHRASES.pattern("OF_A_FRAME")
_STATES = _PHRASES.pattern("STATES")
_OF_A_SETUP = _PHRASES.pattern("OF_A_SETUP")
_ASKS = _PHRASES.pattern("ASKS")


def is_unread_statement(text: str) -> bool:
    """Tell whether `text`, in which no fact was read, seems to state one about the recording.

    Such a statement is no question: an answer to it would pass over what was meant.
    """
    text = normalised_text(text)
    if _OF_A_SETUP.match(text) and not _ASKS.search(text):
        return True
    is_said = bool(_STATEMENT.match(text) and _STATES.search(text))
    is_of_a_frame = bool(_OF_A_FRAME.search(text)) and not motions_named(text)
    return is_said and is_of_a_frame and not _ASKS.search(text)
