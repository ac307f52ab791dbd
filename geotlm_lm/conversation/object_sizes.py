"""Remove object sizes from a question: "the cap, 28 mm wide", "28 mm caps".

They would else be read as amounts of motion.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.number_words import NUMBER
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.quantities import UNITS

_LENGTH_UNIT = "|".join(f"(?:{words})" for words, unit, _ in UNITS if unit == "mm")
_PHRASES = Phrases("object_sizes", NUMBER=NUMBER, LENGTH_UNIT=_LENGTH_UNIT)
_SIZES = tuple(re.compile(words) for words in _PHRASES.each("SIZES"))
"""What is taken for the size of a thing; `before` stays."""

_IS_CLAIMED = _PHRASES.pattern("IS_CLAIMED")
_GOES_ON = _PHRASES.pattern("GOES_ON")


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
