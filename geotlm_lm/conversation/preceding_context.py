"""Remove the sentences before a question: they are context, and no claim to be judged.

"I moved the robot arm to the right. Which way does it slide?" asks which way, whatever was moved
to the right before.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.canonical_wording import in_canonical_words
from geotlm_lm.conversation.kinds import (
    asked_amount,
    asked_kind,
    asks_direction,
    asks_whether_moving,
)
from geotlm_lm.conversation.motion_claims import asks_yes_or_no, claimed_motions, offered_options
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.quantities import quantities
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("preceding_context")
_SENTENCES = re.compile(r"(?<=[.!;])\s+(?=\S)")
_OPENLY = _PHRASES.pattern("OPENLY")
_SUPPOSES = _PHRASES.pattern("SUPPOSES")
_SOMEBODY = _PHRASES.pattern("SOMEBODY")
_FELT = _PHRASES.pattern("FELT")
_OF_THE_FRAME = _PHRASES.pattern("OF_THE_FRAME")
_RECORDED = _PHRASES.pattern("RECORDED")
_TOUCHING = _PHRASES.pattern("TOUCHING")
_CHANGES = ("mirrored", "reversed", "viewpoint", "undo", "thread")


def without_context(question: str) -> str:
    """Return the question at the end of a text without the sentences before it.

    Only where these name a motion or a number, which would pass for a claim; suppositions, choices,
    questions and what is said of the image or the view stay. Before a yes-or-no question only what
    somebody did is context.
    """
    *before, last = _SENTENCES.split(question.strip())
    context = _RECORDED.sub(" ", " ".join(before).lower())
    before = [without_openers(one) for one in before]
    if not before or offered_options(question):
        return question
    if any(_FELT.match(one) for one in before):
        return question
    is_done = all(_SOMEBODY.match(one) for one in before)
    if is_done and (in_canonical_words(last) != last or _asks_contact(last)):
        return last  # asks for contact or slip, whatever was done
    if not (_is_open(last) or (is_done and _claims(last))):
        return question
    if motions_named(context) and (
        _OF_THE_FRAME.search(context) or asked_kind(context) in _CHANGES
    ):
        return question
    is_told = not any("?" in one or _SUPPOSES.match(one) for one in before)
    is_choice = asks_yes_or_no(context) or re.search(r"\bor\b", context)
    passes_for_a_claim = motions_named(context) or quantities(context)
    return last if is_told and passes_for_a_claim and not is_choice else question


def _asks_contact(text: str) -> bool:
    lower = text.lower()
    return bool(_TOUCHING.search(lower)) and asks_yes_or_no(lower) and not motions_named(text)


def _claims(text: str) -> bool:
    is_of_a_way = motions_named(text)
    return not is_of_a_way and (claimed_motions(text) is not None or asks_whether_moving(text))


def _is_open(text: str) -> bool:
    lower = text.lower()
    if asks_yes_or_no(lower) or motions_named(lower):
        return False
    is_open = asks_direction(text) or _OPENLY.match(without_openers(text))
    return bool(is_open) or asked_amount(text) is not None
