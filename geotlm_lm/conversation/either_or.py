"""Recognise questions that offer a state and its opposite: "is it moving or still?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_choices import REST
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("either_or")
_MOTION = _PHRASES.group("MOTION")
_TOUCH = _PHRASES.group("TOUCH")
_NO_TOUCH = _PHRASES.group("NO_TOUCH")
_ACROSS = _PHRASES.group("ACROSS")
_ALONG = _PHRASES.group("ALONG")
_AHEAD = _PHRASES.text("AHEAD")
_BACK = _PHRASES.text("BACK")
_NEARS = _PHRASES.group("NEARS")
_LEAVES = _PHRASES.group("LEAVES")
_OPENS = _PHRASES.text("OPENS")


def _either(one: str, other: str) -> re.Pattern[str]:
    """Return what matches a whole question that offers both, in either order."""
    then = r",? or (?:is it |was it )?"
    return re.compile(rf"{_OPENS}(?:{one}{then}{other}|{other}{then}{one})\W*")


_IS_TOUCHED = "Is anything touching the gel?"

_OR_BOTH = _PHRASES.pattern("OR_BOTH")

_OPPOSITES = (
    (_either(_MOTION, REST), OPEN_QUESTION),
    (_either(_ACROSS, _ALONG), OPEN_QUESTION),
    (_either(_AHEAD, _BACK), OPEN_QUESTION),
    (_PHRASES.pattern("SIGN_EITHER"), OPEN_QUESTION),
    (_either(_NEARS, _LEAVES), OPEN_QUESTION),
    (_either(_TOUCH, _NO_TOUCH), _IS_TOUCHED),
    (_OR_BOTH, "Is it sliding or turning?"),
    (_PHRASES.pattern("CONTACT_EITHER"), OPEN_QUESTION),
)


_IS_GOING = _PHRASES.text("IS_GOING")
_IS_OVER = _PHRASES.text("IS_OVER")
_OVER_OR_NOT = tuple(
    re.compile(rf"{one},? or {other}(?: now| already)?[ ?.!]*")
    for one, other in ((_IS_GOING, _IS_OVER), (_IS_OVER, _IS_GOING))
)

OF_THE_END = (
    "It goes so between the first and the last frame used; whether it goes on after, or stopped "
    "within them, I cannot tell: `geotlm-lm watch` tells when each motion of a recording ends."
)
"""Said beside an answer to whether a motion is over."""


def asked_whether_over(question: str) -> str | None:
    """Return "Is it turning?" of "is it still turning or did it stop?"; None of any other text."""
    text = without_openers(question)
    said = next((found for words in _OVER_OR_NOT if (found := words.fullmatch(text))), None)
    return said and f"Is it {said['going']}?"


def without_opposites(question: str) -> str:
    """Return a question that asks openly where `question` offers a state and its opposite.

    "Is it moving or stationary?" is answered by how it moves; a verdict, as to a claim, would leave
    open on which of the two it is. What asks anything besides stays as it is.
    """
    text = without_openers(question)
    return next((asked for words, asked in _OPPOSITES if words.fullmatch(text)), question)
