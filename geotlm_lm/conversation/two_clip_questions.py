"""Classify questions about two clips: how they relate, or something about one of them."""

from __future__ import annotations

import re

from geotlm_lm.conversation.clip_names import named_alone, place_named
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers

_PHRASES = Phrases("two_clip_questions")
_MOTION = _PHRASES.pattern("MOTION")
_RELATION = _PHRASES.pattern("RELATION")
_SAME_WAY = _PHRASES.pattern("SAME_WAY")
_OF_SOMETHING_ELSE = _PHRASES.pattern("OF_SOMETHING_ELSE")
_EACH_ALIKE = _PHRASES.pattern("EACH_ALIKE")
_EACH_AMOUNT = _PHRASES.pattern("EACH_AMOUNT")
_EACH_RATE = _PHRASES.pattern("EACH_RATE")
_OF_BOTH = _PHRASES.pattern("OF_BOTH")
_WITHIN = _PHRASES.pattern("WITHIN")
_IT = _PHRASES.pattern("IT")
_NOTHING_ASKED = _PHRASES.pattern("NOTHING_ASKED")
_BETWEEN = _PHRASES.text("BETWEEN")
_SAID = tuple(
    (re.compile(rf"(?:{words}){_BETWEEN}\W*"), known)
    for words, known in (
        (_PHRASES.text("CHANGED"), "Are they different?"),
        (_PHRASES.text("REVERSED"), "Are they opposite?"),
        (_PHRASES.text("DIFFERENCE"), "How far did each one go?"),
        (_PHRASES.text("BACK_AGAIN"), "Does the second undo the first?"),
    )
)
"""What is asked of two clips without a word for either of them."""

_MORE_THAN_BEFORE = _PHRASES.pattern("MORE_THAN_BEFORE")
_FURTHER = {"more": "further"}
_THE_FIRST = _PHRASES.pattern("THE_FIRST")


def canonical_two_clip_question(question: str) -> str | None:
    """Rewrite a question on what changed between two clips in trained wording, else None."""
    text = without_openers(question)
    if (said := _MORE_THAN_BEFORE.fullmatch(text)) is not None:
        more = said["more"] or said["so"]
        verb = "slide" if said["slide"] else "turn" if said["turn"] else "go"
        return f"Does the second {verb} {_FURTHER.get(more, more)} than the first?"
    if _THE_FIRST.fullmatch(text) and text.strip(" ?!.") not in ("before", "last time"):
        return "And the first one?"
    return next((known for words, known in _SAID if words.fullmatch(text)), None)


def asks_relation(question: str) -> bool:
    """Tell whether `question` asks for the directions of two clips, or if they are equal.

    "Are they the same?" does, "are they the same object?" does not.
    """
    text = normalised_text(question)
    if _SAME_WAY.search(text) or _EACH_ALIKE.search(text):
        return True
    if _OF_SOMETHING_ELSE.search(text):
        return False
    return bool(_MOTION.search(text) or _RELATION.search(text) or motions_named(text))


def asks_each_amount(question: str) -> str | None:
    """Return "magnitude" or "rate" where it is asked how far, or how fast, both go; else None."""
    text = normalised_text(question)
    if not _EACH_AMOUNT.search(text) or _RELATION.search(text):
        return None
    return "rate" if _EACH_RATE.search(text) else "magnitude"


def asks_of_one(question: str) -> tuple[int, str] | None:
    """Return which clip alone, 0 or 1, is asked about and what; None where it is not one alone.

    What is asked is told as of a single clip, "which way does it go?"; it is empty where there is
    no more than "and the first one?".
    """
    text = re.sub(r" of (?:the two|them|both)\b", "", normalised_text(question))
    one = named_alone(text)
    if one is None or _RELATION.search(text):
        return None
    before, after = text[: one.start()], text[one.end() :]
    is_place = _WITHIN.search(before) and _IT.search(before + after) and not one["own"]
    if is_place:  # "which way does it turn in the second clip?"
        before, after = _WITHIN.sub("", before), after.lstrip(" ,")
    if _OF_BOTH.search(_IT.sub("", before + after) if is_place else before + after):
        return None
    asked = f"{before}{'' if is_place else 'its' if one['own'] else 'it'}{after}"
    return place_named(one), "" if _NOTHING_ASKED.fullmatch(asked) else asked
