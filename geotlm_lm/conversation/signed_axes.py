"""Translate signs of x, y, rows and columns into directions; y and rows grow downwards."""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("signed_axes")
_END = _PHRASES.text("END")
_SIGN = _PHRASES.pattern("SIGN")
_EITHER = tuple(re.compile(rf"{words}{_END}") for words in _PHRASES.each("EITHER_SIGN"))
_GOES_ALONG = _PHRASES.pattern("GOES_ALONG")
_MOTION = _PHRASES.pattern("MOTION")
_ENDED = _PHRASES.pattern("ENDED")
_TOWARDS = _PHRASES.pattern("TOWARDS")
_OPPOSED = _PHRASES.pattern("OPPOSED")

_OF_A_VECTOR = (
    (_PHRASES.text("THERE_IS_A_VECTOR"), "Does it slide?"),
    (_PHRASES.text("WAY_OF_A_VECTOR"), OPEN_QUESTION),
    (_PHRASES.text("CLAIMED_WAY_OF_A_VECTOR"), "Is it moving {way}?"),
    (_PHRASES.text("VECTOR_IS_ZERO"), "It does not slide, right?"),
    (_PHRASES.text("COMPONENT_IS_ZERO"), "It does not slide along {axis}, right?"),
)

_OF_A_TURN = (
    (_PHRASES.text("SIGN_OF_ANGLE"), OPEN_QUESTION),
    (_PHRASES.text("ANGLE_IS_POSITIVE"), "Is it turning clockwise?"),
    (_PHRASES.text("ANGLE_IS_NEGATIVE"), "Is it turning counterclockwise?"),
    (_PHRASES.text("ANGLE_IS_EITHER"), OPEN_QUESTION),
)
"""Clockwise as drawn is positive: from x, to the right, towards y, down."""

CLOCKWISE_IS_POSITIVE = "Clockwise as drawn is a positive angle: from x, right, towards y, down."

_PLAINLY = tuple((re.compile(words), asked) for words, asked in (*_OF_A_VECTOR, *_OF_A_TURN))


def asks_sign_of_turn(question: str) -> bool:
    """Tell whether a question asks for the sign of the turning angle, a convention."""
    text = without_openers(question)
    return any(re.fullmatch(words, text) for words, _ in _OF_A_TURN)


def canonical_axis_question(question: str) -> str | None:
    """Rewrite a question about a sign or a vector as one about a direction; None for others.

    "Is dx negative?" asks whether it goes left, "does the row index increase?" whether down.
    """
    text = without_openers(question)
    for words, asked in _PLAINLY:
        if (said := words.fullmatch(text)) is not None:
            parts = said.groupdict()
            return asked.format(way=parts.get("way"), axis="x" if parts.get("dx") else "y")
    if any(words.fullmatch(text) for words in _EITHER):
        return OPEN_QUESTION
    if (said := _SIGN.fullmatch(text)) is not None:
        is_across = said["x"] or said["column"]
        if not is_across and _OPPOSED.fullmatch(said["plus"] or said["minus"]):
            return OPEN_QUESTION
        return f"Is it moving {_way(bool(is_across), said['plus'] is not None)}?"
    if (towards := _TOWARDS.search(text)) is not None:
        if towards["either"] or towards["choice"]:
            return OPEN_QUESTION
        is_plus = towards["how"] in ("increasing", "larger", "higher", "greater")
        way = _way(towards["across"] is not None, is_plus)
        return f"{text[: towards.start()]}{way}{text[towards.end() :]}"
    along = _GOES_ALONG.search(text)
    if along is None or along["place"] or " or " in text:
        return None
    if not _MOTION.search(text[: along.end()]) and not _ENDED.fullmatch(text[along.end() :]):
        return None  # "in positive x coordinates" is a place
    way = _way(along["of"] == "x", along["sign"] in ("+", "positive", "plus"))
    return f"{text[: along.start()]}{along['verb']}{way}{text[along.end() :]}"


def counts_pixels(question: str) -> bool:
    """Tell whether `question` is in terms of rows or columns of the recorded image."""
    text = without_openers(question)
    found = (words.fullmatch(text) for words in (_SIGN, *_EITHER))
    return any(said["column"] or said["row"] for said in found if said is not None)


def _way(is_across: bool, is_plus: bool) -> str:
    return ("left", "right")[is_plus] if is_across else ("up", "down")[is_plus]
