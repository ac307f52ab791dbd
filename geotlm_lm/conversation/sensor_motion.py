"""Rewrite questions about the sensor's own motion as of the object relative to the sensor."""

from __future__ import annotations

from geotlm_lm.conversation.amount_questions import canonical_amount_question
from geotlm_lm.conversation.kinds import asked_amount, asked_kind, asks_whether_moving
from geotlm_lm.conversation.motion_claims import claims_motion
from geotlm_lm.conversation.motion_questions import canonical_motion_question
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("sensor_motion")
_SENSOR = _PHRASES.pattern("SENSOR")
_OBJECT = _PHRASES.pattern("OBJECT")


def as_object_motion(question: str) -> str | None:
    """Rewrite a question about the sensor's motion as one about "it".

    How far a sensor moves is how far the object does, seen from it; which way is the other way. An
    open question for the way stays as it is: None.
    """
    if asked_kind(question) != "actor" or len(_SENSOR.findall(question.lower())) != 1:
        return None
    text = _SENSOR.sub("it", question.lower())
    asks_how = (
        asked_amount(text) or canonical_motion_question(text) or canonical_amount_question(text)
    )
    return text if asks_how or claims_motion(text) or asks_whether_moving(text) else None


def names_the_object(question: str) -> bool:
    """Tell whether `question` asks how the object moves, though the sensor was said to."""
    return bool(_OBJECT.search(normalised_text(question)))
