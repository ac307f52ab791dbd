"""Split a text that asks for the direction and the amount into two questions."""

from __future__ import annotations

import re

from geotlm_lm.conversation.amount_questions import canonical_amount_question
from geotlm_lm.conversation.future_questions import asks_future_motion
from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving
from geotlm_lm.conversation.motion_claims import claims_motion, offered_options
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named
from geotlm_lm.conversation.non_tactile_questions import asks_beyond_touch
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.unanswerable import asks_place
from geotlm_lm.conversation.wording import capitalised
from geotlm_lm.core.labels import DIRECTED

_PHRASES = Phrases("compound_questions")
_AND_HOW = _PHRASES.pattern("AND_HOW", re.IGNORECASE)
_THEN = _PHRASES.pattern("THEN", re.IGNORECASE)

_TWO_MARKS = re.compile(r"^(?P<first>[^?]+\?)\s+(?P<second>[^?]+\?.*)$")
_WHERE = _PHRASES.pattern("WHERE", re.IGNORECASE)
_WHY = _PHRASES.pattern("WHY", re.IGNORECASE)
_NUMBERED = _PHRASES.pattern("NUMBERED", re.IGNORECASE)


def split_questions(question: str) -> tuple[str, str] | None:
    """Split a text that asks two things into two questions; None where it asks one.

    Both have to be of a kind that their words tell: a lettered choice, an opener or a presumption
    before the question itself makes no second one.
    """
    why = _WHY.fullmatch(question)
    if why is not None and claimed_motion(why["asked"]) in DIRECTED:
        return f"{capitalised(why['asked'])}?", "Why?"
    said = _THEN.match(question) or _AND_HOW.match(question) or _TWO_MARKS.match(question)
    if said is None or offered_options(question):
        return None
    asked = said["first"], said["second"] or said["other"]
    first, second = (_NUMBERED.sub("", part.strip()) for part in asked)
    if _kind(first) == "contact":
        second = _WHERE.sub("Where is the contact?", second, count=1)
    kinds = [_kind(first), _kind(second)]
    if None in kinds or kinds[0] == kinds[1] or "comparison" in kinds or "order" in kinds:
        return None
    return first, second


def _kind(question: str) -> str | None:
    """Return the kind of a question as far as its words tell it."""
    if asks_beyond_touch(question):
        return "refusal"
    if asks_future_motion(question):
        return "future"
    kind = asked_kind(canonical_amount_question(question) or question)
    if kind is not None:
        return kind
    if asks_place(question):
        return "place"
    if asks_direction(question) or len(motions_named(question)) > 1:
        return "direction"
    if asks_whether_moving(question):
        return "moving"
    if re.search(r"\b(?:contact|touch\w*)\b", question, re.IGNORECASE):
        return "contact"
    is_terse = len(question.split()) <= 2 and question.endswith("?")
    if is_terse and claimed_motion(question) is not None:
        return "verify"
    is_presumed = re.match(r"\W*(?:why|how)\b", question, re.IGNORECASE)
    return "verify" if claims_motion(question) and not is_presumed else None
