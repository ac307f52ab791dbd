"""Questions that stand inside another sentence: "I can't tell whether it turns, can you?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.wording import capitalised

_WONDERS = (
    r"(?:(?:sorry|hm+|well|hi|hello|hey)[,:.]? +)?(?:i|we)(?: (?:really|just|still))?"
    r"(?: (?:can't|cannot|can not|couldn't|could not|don't|do not) (?:really |quite )?"
    r"(?:tell|see|say|know|make out|feel|decide)|(?: am|'m| are|'re) (?:not sure|unsure)| wonder)"
)
_CAN_YOU = (
    r"(?:[,;.!?:]| -+)? *(?:but )?(?:can|could|do|would) you"
    r"(?: (?:tell|see|say|know|feel|help))?(?: me)?(?: please)?[ ?.!]*"
)
_WHETHER = re.compile(
    rf"{_WONDERS} (?:whether|if) (?P<who>it|this|that|(?:the|my) \w+)(?P<does>'s| is| was) "
    rf"(?P<what>.+?)(?:{_CAN_YOU}|[ ?.!]*)",
    re.IGNORECASE,
)
_WHICH = re.compile(
    rf"{_WONDERS} (?P<asked>(?:which|what) (?:way|direction) .+?)(?:{_CAN_YOU}|[ ?.!]*)",
    re.IGNORECASE,
)


def asked_within(question: str) -> str:
    """Return the question that a sentence about not knowing holds; any other text as it is."""
    text = " ".join(question.replace("\u2019", "'").split())
    if (which := _WHICH.fullmatch(text)) is not None:
        asked = which["asked"]
        return f"{capitalised(asked)}?"
    if (whether := _WHETHER.fullmatch(text)) is not None:
        does = whether["does"].strip().lower().replace("'s", "is")
        return f"{does.capitalize()} {whether['who']} {whether['what']}?"
    return question
