"""Recognise questions to which "something is touching" or "it is moving" is an answer.

A model that reads words it does not know says one of the two, however sure: of a crack, of dust, of
itself. Of a definite thing ("is the cable mine?") only a verb that names no motion tells so.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import GO, SLIDE, STIR, TURN, WOBBLE
from geotlm_lm.conversation.text_normalisation import normalised_text

_GEL = r"(?:gel|sensor|pad|skin|fingertip|finger|gripper)"
_SOMETHING = (
    r"(?:anything|something|anybody|somebody|nothing|(?:an |any |some |the )?(?:object|thing))"
)
_THERE = re.compile(r"\b(?:is|are|was|were) there\b(?P<what>.*)")
_OF_CONTACT = re.compile(
    r"\b(?:un)?touch\w*|\bcontact(?:ing|ed)?\b|\b(?:press|push|lean|rest|lying|sitting|h[eo]ld|grip"
    r"|grasp|hit|bump|collid|reach)\w*"
    rf"|\b(?:on|at|against) (?:the |your |my )?{_GEL}\b"
    rf"|\b{_SOMETHING}(?: (?:is|was|really|now|at all))? (?:there|present|detected|felt)\b"
    rf"|\b(?:feel|felt|sens|notic|detect)\w* {_SOMETHING}\b|\bthere now\b"
)
_IS_THERE_CONTACT = re.compile(
    r"\b(?:un)?touch\w*|\bcontact\b|^ (?:(?:any|some) )?contacts\b"
    rf"|^ (?:(?:now|still|really) )?{_SOMETHING}(?: (?:there|here|now|at all|or not|or nothing"
    rf"|yes or no|please|present|detected"
    rf"|(?:on|at|against|near|in|inside) (?:the |your |my )?(?:{_GEL}|hand|grasp|grip)))*[ ,?.!]*"
    r"(?:thanks|please|yes or no|be brief|just asking|in this clip|\W)*$"
)
_OF_MOTION = re.compile(
    rf"\b(?:un|im)?(?:{TURN}|{SLIDE}|{GO}|{STIR}|{WOBBLE}|motion|mobil|still|static"
    r"|station|rest|dynamic|happen"
    r"|chang|activ|translat|displac|clock|push|press|pull|squash|squeez|way|direction)\w*"
    r"|\b(?:go|goes|going|gone|went)\b|\bdo(?:es|ing)? (?:some|any)thing\b"
)
_DEFINITE = re.compile(
    r"\b(?:is|was|are|were|does|did|do|has|have|isn't|doesn't)"
    r" (?:it|this|that|these|those|(?:the|my|your|his|her|our) \S+)\b"
)
_DOING = re.compile(
    r"\b(?:is|was|are|were) (?:it|this|that|(?:the|my|this|that) \w+) "
    r"(?:being )?(?!being\b)\w+(?:ing|ed)\b"
)


def speaks_of_motion(text: str) -> bool:
    """Tell whether `text` has any word for a motion, a direction or rest."""
    return bool(_OF_MOTION.search(text.lower()))


def is_unasked_existence(kind: str | None, question: str) -> bool:
    """Tell whether an answer "touching" or "moving" meets a question that asks neither.

    Args:
        kind: Of the model's answer.
        question: What was asked.
    """
    text = normalised_text(question)
    if kind not in ("contact", "moving"):
        return False
    there = _THERE.search(text)
    if kind == "contact" and there is not None:
        return not _IS_THERE_CONTACT.search(there["what"])
    if (_OF_CONTACT if kind == "contact" else _OF_MOTION).search(text):
        return False
    return not _DEFINITE.search(text) or (kind == "moving" and bool(_DOING.search(text)))
