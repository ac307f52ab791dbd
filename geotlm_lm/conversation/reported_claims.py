"""Recognise reported claims to be judged: "she says it goes left. Is she right?"."""

from __future__ import annotations

from geotlm_lm.conversation.indirect_questions import embedded_claim
from geotlm_lm.conversation.motion_claims import claimed_motion_class
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("reported_claims")
_SAID = _PHRASES.pattern("SAID")
_PUT_UP = _PHRASES.pattern("PUT_UP")
_JUDGED = _PHRASES.pattern("JUDGED")
_WHO_IS_RIGHT = _PHRASES.pattern("WHO_IS_RIGHT")
_EXPECTED = _PHRASES.pattern("EXPECTED")
_TOUCHES = _PHRASES.pattern("TOUCHES")
_MOVES = _PHRASES.pattern("MOVES")
_DENIED = _PHRASES.pattern("DENIED")


def question_about_report(question: str) -> str | None:
    """Rewrite a reported claim to be judged as a question; None for any other text.

    Of claims that differ ("he says left, I say right; who is right?") it is asked which way it is.
    """
    text = normalised_text(question)
    if (said := _EXPECTED.fullmatch(text)) is not None:
        if said["what"].startswith("have ") and not said["be"]:
            return f"Has {said['who']} {said['what'].removeprefix('have ')}?"
        return f"{'Is' if said['be'] else 'Does'} {said['who']} {said['what']}?"
    if not _PUT_UP.search(text):
        return None
    if (said := _JUDGED.fullmatch(text)) is not None:
        return _judged(said["claim"], bool(said["right"]))
    said = _WHO_IS_RIGHT.fullmatch(text)
    if said is None or len(motions_named(said["claims"])) < 2:
        return None
    # "A: up, B: down. Which one is right?" is a choice: nobody says anything.
    return None if said["which"] and not _SAID.search(said["claims"]) else OPEN_QUESTION


def _judged(claim: str, is_right: bool) -> str | None:
    """Return what asks whether a claim is right, or wrong; None where nothing is claimed.

    Contact and motion as such are asked for in the words that every model knows.
    """
    is_of_a_way = len(motions_named(claim)) == 1
    if not is_of_a_way and is_right and not _DENIED.search(claim):
        if _TOUCHES.search(claim):
            return "Is anything touching the gel?"
        if _MOVES.search(claim):
            return "Is it moving at all?"
        if claimed_motion_class(f"Is it so: {claim}") is not None:
            asked = f"tell me whether {claim}"
            return (
                embedded_claim(asked) if embedded_claim(asked) != asked else f"Is it so: {claim}?"
            )
    is_of_a_kind = claimed_motion_class(f"Is it so: {claim}") is not None
    if not is_of_a_way and not is_of_a_kind:
        return None
    return f"Is it {'true' if is_right else 'false'} that {claim}?"
