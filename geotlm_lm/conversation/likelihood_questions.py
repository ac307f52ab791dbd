"""Find the motion whose likelihood is asked: "is it likely that it turns clockwise?"."""

from __future__ import annotations

from geotlm_lm.conversation.motion_claims import claimed_motions
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.labels import Motion

_PHRASES = Phrases("likelihood_questions")
_DENIED = _PHRASES.pattern("DENIED")
_OF_THE_ANSWER = _PHRASES.pattern("OF_THE_ANSWER")


def likelihood_subject(question: str) -> frozenset[Motion] | None:
    """Return the motions whose likelihood is asked; None if none is named.

    None too where it denies them: how likely the rest is, is then asked of the answer before.
    """
    text = normalised_text(question)
    is_of_it = _DENIED.search(text) or _OF_THE_ANSWER.search(text)
    return None if is_of_it else claimed_motions(f"Is it so: {question}")
