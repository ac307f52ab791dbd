"""Recognise questions that offer a state and its opposite: "is it moving or still?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_choices import REST
from geotlm_lm.conversation.motion_verbs import GOES, SLIDES, TURNS, forms
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import without_openers

_MOTION = r"(?:moving|in motion|in movement|dynamic|mobile)"
_TOUCH = r"(?:touching|touched|in contact|contact)"
_NO_TOUCH = r"(?:not (?:touching|touched|in contact)|no contact|untouched)"
_AXIS = r"(?:(?:along |in )?(?:the )?{}(?:[ -](?:axis|direction))?)"
_ACROSS, _ALONG = (
    rf"(?:horizontal(?:ly)?|sideways|{_AXIS.format('x')})",
    rf"(?:vertical(?:ly)?|up and down|{_AXIS.format('y')})",
)
_AHEAD, _BACK = (
    rf"{_AXIS.format(sign + '[xy]')}"
    for sign in (r"(?:\+ ?|positive |plus )", r"(?:- ?|negative |minus )")
)
_NEARS, _LEAVES = (
    r"(?:approach(?:es|ed|ing)?|advanc(?:e|es|ed|ing))",
    r"(?:(?:retreat|withdraw)(?:s|ed|ing)?|withdrew|reced(?:e|es|ed|ing)|leav(?:e|es|ing))",
)
_SIGNED = (
    r"(?:(?:is|was) )?(?:the )?"
    r"(?:d[xy]|delta[ -]?[xy]|[xy]|[xy][ -](?:displacement|shift|motion))(?: is)? "
)
_OPENS = (
    r"(?:(?:is|was|does|did) (?:it|(?:the|my) (?!sensor|gel|camera|robot"
    r"|gripper|finger)\w+) (?:(?:now|moving|sliding|going|move|slide|go) )?)?"
)

_CONTACT = r"(?:(?:is|was|did|does|has) (?:the )?contact (?:being |been )?)?"
_MADE, _BROKEN = (
    r"(?:made?|mak(?:e|ing)|beg(?:in|an|inning)|start(?:ed|ing)?|established)",
    r"(?:br(?:eak|eaking|oken)|lost|los(?:e|ing)|end(?:ed|ing)?|stop(?:ped|ping)?)",
)


def _either(one: str, other: str) -> re.Pattern[str]:
    """Return what matches a whole question that offers both, in either order."""
    then = r",? or (?:is it |was it )?"
    return re.compile(rf"{_OPENS}(?:{one}{then}{other}|{other}{then}{one})\W*")


_IS_TOUCHED = "Is anything touching the gel?"

_TURN, _SLIDE = (
    rf"(?:an? )?(?:{forms(verbs, 'gerund', 'base')}|{nouns})"
    for verbs, nouns in ((TURNS, "rotation"), (SLIDES, "translation"))
)
_OR_BOTH = re.compile(
    rf"{_OPENS}(?:either )?(?:{_TURN}(?:,| or) {_SLIDE}|{_SLIDE}(?:,| or) {_TURN}),? or both\W*"
)
"""One motion is told, so that a choice among both kinds and the two together is one of a kind."""

_OPPOSITES = (
    (_either(_MOTION, REST), OPEN_QUESTION),
    (_either(_ACROSS, _ALONG), OPEN_QUESTION),
    (_either(_AHEAD, _BACK), OPEN_QUESTION),
    (re.compile(rf"{_SIGNED}(?:positive or negative|negative or positive)\W*"), OPEN_QUESTION),
    (_either(_NEARS, _LEAVES), OPEN_QUESTION),
    (_either(_TOUCH, _NO_TOUCH), _IS_TOUCHED),
    (_OR_BOTH, "Is it sliding or turning?"),
    (re.compile(rf"{_CONTACT}(?:{_MADE} or {_BROKEN}|{_BROKEN} or {_MADE})\W*"), OPEN_QUESTION),
)


_IT = r"(?:it|this|that|(?:the|my) \w+)"
_GOING = rf"(?P<going>{forms(TURNS + SLIDES + GOES, 'gerund')}|in motion)"
_IS_GOING = rf"(?:(?:is|was) )?(?:{_IT} )?(?:still )?{_GOING}"
_IS_OVER = (
    rf"(?:(?:has|had|did|is|was) )?(?:{_IT} )?(?:now |already |just )?(?:(?:stop(?:ped)?"
    rf"|halt(?:ed)?|come to (?:rest|a stop|a halt))(?: {forms(TURNS + SLIDES + GOES, 'gerund')})?"
    rf"|(?:over|finished|ended|done)(?: now)?|{REST} (?:now|again))"
)
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
