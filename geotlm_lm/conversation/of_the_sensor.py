"""What is asked of the sensor's own motion, told as of the object relative to it."""

from __future__ import annotations

import re

from geotlm_lm.conversation.bare_amounts import asked_of_an_amount
from geotlm_lm.conversation.bare_motions import asked_of_a_motion
from geotlm_lm.conversation.claims import claims_motion
from geotlm_lm.conversation.kind_words import HOLDER
from geotlm_lm.conversation.kinds import asked_amount, asked_kind, asks_whether_moving
from geotlm_lm.conversation.motion_verbs import GO, SLIDE, TURN
from geotlm_lm.conversation.plain_text import plain_text

_SENSOR = re.compile(
    rf"\b(?:the|my) (?:tactile )?{HOLDER}"
    r"(?: itself)?\b(?! (?:\w+ )?(?:to|across|over) the (?:sensor|gel)\b)"
)
_OBJECT = re.compile(
    r"\b(?:does|do|did|is|was|has) (?:the|my) object (?:itself )?"
    rf"(?:go|{GO}|{SLIDE}|{TURN})\w*"
)


def as_of_it(question: str) -> str | None:
    """Return a question for an amount, or for a yes or no, of the sensor's motion told of "it".

    How far a sensor moves is how far the object does, seen from it; which way is the other way. An
    open question for the way stays as it is: None.
    """
    if asked_kind(question) != "actor" or len(_SENSOR.findall(question.lower())) != 1:
        return None
    text = _SENSOR.sub("it", question.lower())
    asks_how = asked_amount(text) or asked_of_a_motion(text) or asked_of_an_amount(text)
    return text if asks_how or claims_motion(text) or asks_whether_moving(text) else None


def names_the_object(question: str) -> bool:
    """Tell whether `question` asks how the object moves, though the sensor was said to."""
    return bool(_OBJECT.search(plain_text(question)))
