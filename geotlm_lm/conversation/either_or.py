"""Questions that name a state and its opposite, which claim neither: "is it moving or still?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.claims import motions_named, offered_options
from geotlm_lm.core.labels import Motion

_REST = r"(?:still|stationary|static|at rest|motionless|immobile|at a standstill|not moving)"
_MOTION = r"(?:moving|in motion|in movement|dynamic|mobile)"
_MOVING_OR_NOT = re.compile(rf"\b(?:{_MOTION},? or (?:is it )?{_REST}|{_REST},? or {_MOTION})\b")

_TOUCH = r"(?:touching|touched|in contact|contact)"
_NO_TOUCH = r"(?:not (?:touching|touched|in contact)|no contact|untouched|free)"
_TOUCHING_OR_NOT = re.compile(rf"\b(?:{_TOUCH},? or {_NO_TOUCH}|{_NO_TOUCH},? or {_TOUCH})\b")

_MOVES_HOW = "Which way is it moving?"
_IS_TOUCHED = "Is anything touching the gel?"


def without_opposites(question: str) -> str:
    """Return a question that asks openly where `question` offers a state and its opposite.

    "Is it moving or stationary?" is answered by how it moves; a verdict, as to a claim, would leave
    open on which of the two it is.
    """
    text = " ".join(question.lower().split())
    if offered_options(question):
        return question
    for words, asked, opposite in (
        (_MOVING_OR_NOT, _MOVES_HOW, Motion.STILL),
        (_TOUCHING_OR_NOT, _IS_TOUCHED, Motion.NONE),
    ):
        if words.search(text) and set(motions_named(text)) <= {opposite}:
            return asked
    return question
