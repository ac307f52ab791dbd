"""Recognise motions other than the ten known: rolling, tipping, shaking, bending, partial slip."""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("unsupported_motions")
UNSUPPORTED_MOTION = (
    "I tell how it turns, slides, presses and lifts against the gel, not whether it rolls, tips, "
    "shakes, bends or flips over."
)

PARTIAL_SLIP = (
    "I tell whether it slides as a whole, not whether slip begins at the border of the contact."
)

_ASKED = _PHRASES.pattern("ASKED")
_PARTIAL_SLIP = _PHRASES.pattern("PARTIAL_SLIP")


def unsupported_motion_reply(text: str) -> str | None:
    """Return the reply to a question for such a motion, lower case; None for any other.

    With a direction it asks for that one, and whether "it" flips may be asked of the picture.
    """
    if _PARTIAL_SLIP.search(text):
        return PARTIAL_SLIP
    return UNSUPPORTED_MOTION if _ASKED.fullmatch(without_openers(text)) else None
