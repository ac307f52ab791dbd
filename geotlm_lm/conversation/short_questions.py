"""Expand claims of a word or two to whole questions: "turning?", "up or not?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.motion_verbs import PRESSES, base_of
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion

_PHRASES = Phrases("short_questions")
_TURNING = _PHRASES.pattern("TURNING")
_SLIDING = _PHRASES.pattern("SLIDING")
_ROTATION = _PHRASES.pattern("ROTATION")
_SLIP = _PHRASES.pattern("SLIP")
_WAY = _PHRASES.pattern("WAY")
_MOVING = _PHRASES.pattern("MOVING")
_SLASHED = _PHRASES.pattern("SLASHED")

MOST_WORDS = 8
"""Of a claim that is no sentence, with all that may stand around it."""

_KINDS = (
    (_MOVING, "Is it moving?"),
    (_TURNING, "Is it turning?"),
    (_ROTATION, "Is it turning?"),
    (_SLIDING, "Is it sliding?"),
    (_SLIP, "Is it slipping?"),
)


def _ways(offered: str) -> list[str]:
    return re.split(" ?/ ?", offered)


def expanded_question(question: str) -> str:
    """Expand a claim of a word or two to a yes-or-no question; others stay as they are."""
    text = without_openers(question)
    if len(text.split()) > MOST_WORDS:
        return question
    if (offered := _SLASHED.fullmatch(text)) and all(map(claimed_motion, _ways(offered["ways"]))):
        return f"{' or '.join(_ways(offered['ways']))}?"
    said = _WAY.fullmatch(text)
    motion = said and claimed_motion(said["way"])
    if motion:
        if motion in (Motion.PRESS, Motion.RELEASE):
            base = base_of(said["way"])
            done = next((verb[3] for verb in PRESSES if verb[0] == base), said["way"])
            return f"Is it {done}?"  # "pressed or not" asks for a press, not for contact
        verb = "turning " if motion in ROTATIONS else "going " if motion in SLIDES else ""
        return f"Is it {verb}{said['way']}?"
    return next((asked for words, asked in _KINDS if words.fullmatch(text)), question)
