"""Questions that name a state and its opposite, which claim neither: "is it moving or still?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.plain_text import plain_text

_REST = r"(?:still|stationary|static|at rest|motionless|immobile|stable|at a standstill|not moving)"
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
_SIGNED = (
    r"(?:(?:is|was) )?(?:the )?"
    r"(?:d[xy]|delta[ -]?[xy]|[xy]|[xy][ -](?:displacement|shift|motion))(?: is)? "
)
_OPENS = (
    r"(?:(?:and|so|ok|now)[, ]+)?(?:(?:is|was|does|did) (?:it|(?:the|my) (?!sensor|gel|camera|robot"
    r"|gripper|finger)\w+) (?:(?:now|moving|sliding|going|move|slide|go) )?)?"
)


def _either(one: str, other: str) -> re.Pattern[str]:
    """Return what matches a whole question that offers both, in either order."""
    then = r",? or (?:is it |was it )?"
    return re.compile(rf"\W*{_OPENS}(?:{one}{then}{other}|{other}{then}{one})\W*")


_MOVES_HOW = "Which way is it moving?"
_IS_TOUCHED = "Is anything touching the gel?"

_OPPOSITES = (
    (_either(_MOTION, _REST), _MOVES_HOW),
    (_either(_ACROSS, _ALONG), _MOVES_HOW),
    (_either(_AHEAD, _BACK), _MOVES_HOW),
    (re.compile(rf"\W*{_SIGNED}(?:positive or negative|negative or positive)\W*"), _MOVES_HOW),
    (_either(_TOUCH, _NO_TOUCH), _IS_TOUCHED),
)


def without_opposites(question: str) -> str:
    """Return a question that asks openly where `question` offers a state and its opposite.

    "Is it moving or stationary?" is answered by how it moves; a verdict, as to a claim, would leave
    open on which of the two it is. What asks anything besides stays as it is.
    """
    text = plain_text(question)
    return next((asked for words, asked in _OPPOSITES if words.fullmatch(text)), question)
