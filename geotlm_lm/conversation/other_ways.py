"""Ways to move that are none of the ten told: rolling, tipping, shaking, bending, flipping over."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import PICTURE

OTHER_WAYS = (
    "I tell how it turns, slides, presses and lifts against the gel, not whether it rolls, tips, "
    "shakes, bends or flips over."
)

_THING = rf"(?:it|this|that|(?:the|this|that|my) (?!{PICTURE})(?:\w+ )?\w+)"
_OPENS = r"\W*(?:(?:and|so|ok|but)[, ]+)?"
_ROLLS = (
    r"(?:(?:roll|bounc|vibrat|shak|tilt|tip|tipp|bend|stretch|compress|deform|toppl|fold|buckl)"
    r"(?:e|es|ed|s|ing|led|ling|le)?|shook|shaken|bent)"
)
_ASKED = re.compile(
    rf"{_OPENS}(?:did|does|has|is|was) {_THING} (?:(?:ever|now|just|still|being) )?{_ROLLS}"
    r"(?: over| at all)?\W*"
    rf"|{_OPENS}(?:did|does|has|was) (?!it\b|this\b|that\b){_THING} (?:flip|flipped)(?: over)?\W*"
)


def asks_other_way(text: str) -> bool:
    """Tell whether a whole text, in lower case, asks for one of these and names no direction.

    Whether "it" flips may be asked of the picture.
    """
    return _ASKED.fullmatch(text) is not None
