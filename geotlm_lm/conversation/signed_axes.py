"""Signs of x and y, and of rows and columns, told as ways: y and the row numbers grow downwards."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import ENDING, GO, SLIDE
from geotlm_lm.conversation.plain_text import plain_text

_X = r"(?:d ?x|delta[ -]?x|x(?:[ -](?:coordinate|component|displacement|shift|motion|position))?)"
_Y = _X.replace("x", "y")
_COLUMN, _ROW = (
    rf"(?:(?:pixel|image) )?{name}s?(?: (?:index|indices|number|numbers|coordinate|position))?"
    for name in ("column", "row")
)
_AXIS = (
    rf"(?:the |its )?(?:(?P<x>{_X})|(?P<y>{_Y})|(?P<column>{_COLUMN})|(?P<row>{_ROW}))"
    r"(?: of (?:it|(?:the|my|this) (?:\w+ )?\w+))?"
)
_GETS = r"(?:get|gets|getting)"
_GROWS = (
    rf"(?:increas|grow|ris)(?:e|es|s|ing)?|(?:go|goes|going) up|{_GETS} (?:larger|bigger|greater)"
)
_SHRINKS = (
    r"(?:decreas|shrink|fall|drop)(?:e|es|s|ing|ping)?|(?:go|goes|going) down"
    rf"|{_GETS} (?:smaller|less)"
)
_LEAD = r"(?:(?:and|so|ok|now|but|please|then)[,:]? +)*"
_THEN = r"(?:yes or no|or not|then|please|(?:in|of) (?:it|this(?: clip| recording)?))"
_END = rf"(?:[,.]? *{_THEN})*[ ?.!]*"
_SIGN = re.compile(
    rf"{_LEAD}(?:(?:is|was|does|did|do|are) )?(?:the sign of )?{_AXIS} ?(?:(?:is|are) )?"
    rf"(?:(?P<plus>positive|plus|>=? ?0|\+|{_GROWS})|(?P<minus>negative|minus|<=? ?0|-|{_SHRINKS}))"
    rf"{_END}"
)
_CHANGES = rf"(?:{_GROWS}|{_SHRINKS})"
_EITHER = tuple(
    re.compile(rf"{_LEAD}{words}{_END}")
    for words in (
        rf"(?:(?:what|which) (?:is )?)?(?:the )?sign (?:of|has) {_AXIS}",
        rf"(?:is|was|does|did|do|are) {_AXIS} {_CHANGES},? or {_CHANGES}",
    )
)
_GOES_ALONG = re.compile(
    rf"\b(?P<verb>(?:is|was|does|did) (?:\S+ ){{1,3}}?(?:(?:{GO}|{SLIDE}|go|head){ENDING} ?)?)"
    r"(?:along|in|on|to|towards?)(?: the)? "
    r"(?P<sign>[+-]|positive|negative|plus|minus) ?(?P<of>[xy])"
    r"(?:[ -](?:axis|direction|way))?(?: direction)?(?=\W*$|[,.?!]| )"
)

_MOVES_HOW = "Which way is it moving?"

_TOWARDS = re.compile(
    r"\b(?:in the direction of|towards?|to) (?:the )?(?P<how>increasing|larger|higher|greater"
    r"|decreasing|smaller|lower) (?:(?P<across>x|columns?)|y|rows?)"
    r"(?: (?:values?|numbers?|indices|index|coordinates?))?\b"
)


def asked_of_axes(question: str) -> str | None:
    """Return what a question about the sign of x or y asks of a way; None of any other question.

    "Is dx negative?" asks whether it goes left, "does the row index increase?" whether down.
    """
    text = plain_text(question)
    if any(words.fullmatch(text) for words in _EITHER):
        return _MOVES_HOW
    if (said := _SIGN.fullmatch(text)) is not None:
        is_across = said["x"] or said["column"]
        return f"Is it moving {_way(bool(is_across), said['plus'] is not None)}?"
    if (towards := _TOWARDS.search(text)) is not None:
        is_plus = towards["how"] in ("increasing", "larger", "higher", "greater")
        way = _way(towards["across"] is not None, is_plus)
        return f"{text[: towards.start()]}{way}{text[towards.end() :]}"
    along = _GOES_ALONG.search(text)
    if along is None or " or " in text:
        return None
    way = _way(along["of"] == "x", along["sign"] in ("+", "positive", "plus"))
    return f"{text[: along.start()]}{along['verb']}{way}{text[along.end() :]}"


def counts_pixels(question: str) -> bool:
    """Tell whether `question` asks of rows or columns, which are those of the recorded image."""
    text = plain_text(question)
    found = (words.fullmatch(text) for words in (_SIGN, *_EITHER))
    return any(said["column"] or said["row"] for said in found if said is not None)


def _way(is_across: bool, is_plus: bool) -> str:
    return ("left", "right")[is_plus] if is_across else ("up", "down")[is_plus]
