"""Translate signs of x, y, rows and columns into directions; y and rows grow downwards."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import ENDING, GO, SLIDE
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import without_openers

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
_THEN = r"(?:yes or no|or not|then|please|(?:in|of) (?:it|this(?: clip| recording)?))"
_END = rf"(?:[,.]? *{_THEN})*[ ?.!]*"
_SIGN = re.compile(
    rf"(?:(?:is|was|does|did|do|are) )?(?:the sign of )?{_AXIS} ?(?:(?:is|are) )?"
    rf"(?:(?P<plus>positive|plus|>=? ?0|\+|{_GROWS})|(?P<minus>negative|minus|<=? ?0|-|{_SHRINKS}))"
    rf"{_END}"
)
_CHANGES = rf"(?:{_GROWS}|{_SHRINKS})"
_EITHER = tuple(
    re.compile(rf"{words}{_END}")
    for words in (
        rf"(?:(?:what|which) (?:is )?)?(?:the )?sign (?:of|has) {_AXIS}",
        rf"(?:is|was|does|did|do|are) {_AXIS} {_CHANGES},? or (?:(?:is|was|does|did) it )?"
        rf"{_CHANGES}",
    )
)
_PLACE = r"(?:sides?|half|territory|region|area|part|quadrant|edge|end|corner|zone)\b"
_GOES_ALONG = re.compile(
    rf"\b(?P<verb>(?:is|was|does|did) (?:\S+ ){{1,3}}?(?:(?:{GO}|{SLIDE}|go|head){ENDING} ?)?)"
    r"(?:along|in|on|to|towards?)(?: the)? "
    r"(?P<sign>[+-]|positive|negative|plus|minus) ?(?P<of>[xy])"
    r"(?:[ -](?:axis|direction|way))?(?: direction)?(?P<place> {_PLACE})?(?=\W*$|[,.?!]| )"
)
_MOTION = re.compile(
    rf"\b(?:(?:{GO}|{SLIDE}){ENDING}|go|goes|going|head|heads|heading|motion|movement|slippage)\b"
)
_ENDED = re.compile(rf"{_END}")

_HOW = r"(?:increasing|larger|higher|greater|decreasing|smaller|lower)"
_TOWARDS = re.compile(
    rf"\b(?:in the direction of|towards?|to) (?:the )?(?P<how>{_HOW})"
    rf"(?P<either> or (?:(?:to|towards?) )?{_HOW})? (?:(?P<across>x|columns?)|y|rows?)"
    r"(?: (?:values?|numbers?|indices|index|coordinates?))?\b(?P<choice>,? or (?:\w+ ){0,4}?"
    rf"{_HOW}\b)?"
)

_OPPOSED = re.compile(r"(?:ris|fall|drop)\w*|(?:go|goes|going) (?:up|down)")
"""Said of y or a row, "it goes up" is as good as its opposite: up in numbers is down in the image.
A yes or no would leave open which of the two it is to."""

_VECTOR = (
    r"(?:the |this |that |its |an? |any )?"
    r"(?:translation|displacement|motion|slide|sliding|shift|slip) vector"
)
_OF_A_VECTOR = (
    (rf"(?:is|was) there {_VECTOR}{_END}", "Does it slide?"),
    (
        rf"(?:which|what) (?:way|direction) (?:does|did|is|was) {_VECTOR} "
        rf"(?:point|go|face|pointing|going)(?: (?:to|in|towards?))?{_END}",
        OPEN_QUESTION,
    ),
    (
        rf"(?:is|does|did|was) {_VECTOR} (?:point|go|face|pointing|going) "
        rf"(?:to(?:wards?)? (?:the )?)?(?P<way>left|right|up|down)(?:wards?)?{_END}",
        "Is it moving {way}?",
    ),
    (
        rf"(?:is|was|are|were) (?:{_VECTOR}|(?:the )?x,? (?:and|or|/) (?:the )?y[ -]?\w*"
        rf"|(?:the )?d ?x,? (?:and|or) d ?y|(?:the )?displacement) (?:both )?(?:zero|0|null){_END}",
        "It does not slide, right?",
    ),
    (
        rf"(?:is|was) (?:the )?(?:(?P<dx>{_X})|{_Y}) (?:zero|0|null){_END}",
        "It does not slide along {axis}, right?",
    ),
)

_THETA = r"(?:the )?(?:theta|(?:rotation|turning) angle|angle of (?:rotation|turning))"
_OF_A_TURN = (
    (rf"(?:what (?:is|was) )?(?:the )?sign of {_THETA}{_END}", OPEN_QUESTION),
    (rf"(?:is|was) {_THETA} (?:positive|plus|> ?0){_END}", "Is it turning clockwise?"),
    (rf"(?:is|was) {_THETA} (?:negative|minus|< ?0){_END}", "Is it turning counterclockwise?"),
    (
        rf"(?:is|was) {_THETA} (?:positive or negative|negative or positive){_END}",
        OPEN_QUESTION,
    ),
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
