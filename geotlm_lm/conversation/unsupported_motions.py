"""Recognise motions other than the ten known: rolling, tipping, shaking, bending, partial slip."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import PICTURE
from geotlm_lm.conversation.text_normalisation import without_openers

UNSUPPORTED_MOTION = (
    "I tell how it turns, slides, presses and lifts against the gel, not whether it rolls, tips, "
    "shakes, bends or flips over."
)

PARTIAL_SLIP = (
    "I tell whether it slides as a whole, not whether slip begins at the border of the contact."
)

_THING = rf"(?:it|this|that|(?:the|this|that|my) (?!{PICTURE})(?:\w+ )?\w+)"
_ROLLS = (
    r"(?:(?:roll|bounc|vibrat|shak|tilt|tip|tipp|bend|stretch|compress|deform|toppl|fold|buckl)"
    r"(?:e|es|ed|s|ing|led|ling|le)?|shook|shaken|bent)"
)
_ASKED = re.compile(
    rf"(?:did|does|has|is|was) {_THING} (?:(?:ever|now|just|still|being) )?{_ROLLS}"
    r"(?: over| at all)?\W*"
    rf"|(?:did|does|has|was) (?!it\b|this\b|that\b){_THING} (?:flip|flipped)(?: over)?\W*"
)
_PARTIAL_SLIP = re.compile(r"\b(?:incipient|partial|micro|local(?:i[sz]ed)?)[ -]?slip\w*\b")


def unsupported_motion_reply(text: str) -> str | None:
    """Return the reply to a question for such a motion, lower case; None for any other.

    With a direction it asks for that one, and whether "it" flips may be asked of the picture.
    """
    if _PARTIAL_SLIP.search(text):
        return PARTIAL_SLIP
    return UNSUPPORTED_MOTION if _ASKED.fullmatch(without_openers(text)) else None
