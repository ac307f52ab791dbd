"""Remove object sizes from a question: "the cap, 28 mm wide", "28 mm caps".

They would else be read as amounts of motion.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import GO, SLIDE, TURN
from geotlm_lm.conversation.number_words import NUMBER
from geotlm_lm.conversation.quantities import MOTION_NOUN, UNITS

_LENGTH_UNIT = "|".join(f"(?:{words})" for words, unit, _ in UNITS if unit == "mm")
_LENGTH = rf"(?<![\w.,/-])(?:(?:{NUMBER}) ?(?:x|by|to|-) ?)?(?:{NUMBER}) ?-?(?:{_LENGTH_UNIT})"
_EXTENT = (
    r"(?:(?:wide|long|thick|high|tall|deep|across)\b"
    r"|(?:in )?(?:(?:outer|inner) )?(?:diameter|radius|width|length|thickness|height|size)\b)"
)
_NO_NOUN = (
    rf"(?!(?:{MOTION_NOUN}|distance|angle|amount|rate|speed|velocity|maximum|minimum|average|sum|way"
    r"|path|stroke|travel|excess|order|range|course|span|much|more|out|instead|because"
    r"|it|is|was|this|that)\w*\b)"
)
_THE = r"(?:the|this|that|these|those|an?|my|your|its|our)"
_GOES = rf"(?:{TURN}|{SLIDE}|{GO}|go|went|press|push|cover)"
_A_THING = rf"\b{_THE} (?:(?!{_GOES})[a-z]+ )?{_NO_NOUN}(?!{_GOES})[a-z]\w*"

_SIZES = tuple(
    re.compile(words)
    for words in (
        rf"(?P<before>{_A_THING})(?P<aside>,|,? (?:which|that) (?:is|are))? {_LENGTH} {_EXTENT},?",
        rf"(?P<before>{_A_THING} )\((?:about |roughly )?{_LENGTH}(?: {_EXTENT})?\)",
        rf"(?P<before>)(?:,? \b(?:with|of) an? )?\b{_NO_NOUN}(?!{_GOES})[a-z]\w* of {_LENGTH}(?!\w)"
        rf"(?: {_EXTENT})?",
        r"(?P<before>(?:^|\b(?:do|does|did|are|were|have|has|of|these|those|and|my|all) ))"
        rf"{_LENGTH}(?= (?!{MOTION_NOUN}\w*\b)[a-z]+[^s\W]s\b)",
    )
)
"""What is taken for the size of a thing; `before` stays."""

_IS_CLAIMED = re.compile(rf"\b(?:is|was|are|were)(?:n't| not)? {_THE} (?:\w+ ){{0,2}}?\w+$")
_GOES_ON = re.compile(r" *\w+ing\b")


def without_sizes(text: str) -> str:
    """Return `text`, in lower case, without the sizes of things it names beside a motion.

    A size that is itself what is asked stays: "is the cap 28 mm wide?".
    """
    for words in _SIZES:
        text = words.sub(lambda said: _left(said, said.string), text)
    return " ".join(text.split())


def _left(said: re.Match[str], text: str) -> str:
    before, after = text[: said.end("before")], text[said.end() :]
    is_beside = said.groupdict().get("aside") or said[0].endswith(")") or _GOES_ON.match(after)
    is_claimed = said["before"] and _IS_CLAIMED.search(before) and not is_beside
    if is_claimed or not re.search(r"\w", after):
        return said[0]
    return said["before"] or _thing_of(said[0])


def _thing_of(said: str) -> str:
    """Return the noun before "of", unless it names the size: "nut of 10 mm", "diameter of"."""
    return "" if re.match(r",? (?:with|of) ", said) else said.partition(" of ")[0]
