"""What is told before an open question: a context, and never a claim to be judged.

"I moved the robot arm to the right. Which way does it slide?" asks which way, whatever was moved
to the right before.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.claims import asks_yes_or_no, motions_named, offered_options
from geotlm_lm.conversation.kinds import asked_amount, asks_direction
from geotlm_lm.conversation.quantities import quantities

_SENTENCES = re.compile(r"(?<=[.!;])\s+(?=\S)")
_OPENLY = re.compile(
    r"\W*(?:(?:and|so|but|now|ok|please)[, ]+)*(?:by )?(?:which|what|how|where"
    r"|(?:tell me|give me|describe|report|say) (?:the |its |which |what |how ))\b"
)
_SUPPOSES = re.compile(
    r"\W*(?:(?:and|so|but|now|ok|please)[, ]+)*"
    r"(?:if|suppose|supposing|imagine|assume|assuming|when|which|what|how|where|tell|is it|say)\b"
)


def without_context(question: str) -> str:
    """Return the open question at the end of a text without the sentences told before it.

    Only where these name a motion or a number, which would pass for a claim; suppositions, choices
    and questions stay.
    """
    *before, last = _SENTENCES.split(question.strip())
    context = " ".join(before).lower()
    if not before or offered_options(question) or not _is_open(last):
        return question
    is_told = not any("?" in one or _SUPPOSES.match(one.lower()) for one in before)
    is_choice = asks_yes_or_no(context) or re.search(r"\bor\b", context)
    passes_for_a_claim = motions_named(context) or quantities(context)
    return last if is_told and passes_for_a_claim and not is_choice else question


def _is_open(text: str) -> bool:
    lower = text.lower()
    if asks_yes_or_no(lower) or motions_named(lower):
        return False
    return asks_direction(text) or bool(_OPENLY.match(lower)) or asked_amount(text) is not None
