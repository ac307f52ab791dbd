"""Two questions in one text: which way it goes and how far."""

from __future__ import annotations

import re

from geotlm_lm.conversation.claims import claims_motion, motions_named, offered_options
from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving

_AND_HOW = re.compile(
    r"^(?P<first>.+?)[,;]? (?:and|&) (?:by )?"
    r"(?P<second>(?:how (?:far|much|fast|quickly|many|sure)|at (?:what|which) speed)\b.*)$",
    re.IGNORECASE,
)
_TWO_MARKS = re.compile(r"^(?P<first>[^?]+\?)\s+(?P<second>[^?]+\?)\W*$")
_NUMBERED = re.compile(r"^(?:first|second|then|next|and|also|1|2)[:,.)]* +", re.IGNORECASE)


def two_parts(question: str) -> tuple[str, str] | None:
    """Return the two questions of a text that asks two things; None where it asks one.

    Both have to be of a kind that their words tell: a lettered choice, an opener or a presumption
    before the question itself makes no second one.
    """
    said = _AND_HOW.match(question) or _TWO_MARKS.match(question)
    if said is None or offered_options(question):
        return None
    first, second = (_NUMBERED.sub("", said[part].strip()) for part in ("first", "second"))
    kinds = [_kind(first), _kind(second)]
    if None in kinds or kinds[0] == kinds[1] or "comparison" in kinds or "order" in kinds:
        return None
    return first, second


def _kind(question: str) -> str | None:
    """Return the kind of a question as far as its words tell it."""
    kind = asked_kind(question)
    if kind is not None:
        return kind
    if asks_direction(question) or len(motions_named(question)) > 1:
        return "direction"
    if asks_whether_moving(question):
        return "moving"
    if re.search(r"\b(?:contact|touch\w*)\b", question, re.IGNORECASE):
        return "contact"
    is_presumed = re.match(r"\W*(?:why|how)\b", question, re.IGNORECASE)
    return "verify" if claims_motion(question) and not is_presumed else None
