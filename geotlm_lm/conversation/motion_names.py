"""Find the motions that a text names; ambiguous words name none."""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import lru_cache

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.labels import Motion

_PHRASES = Phrases("motion_names")
KEPT = 64
"""Texts that are kept as read: many rules read one question, one after another."""


LOST_CONTACT = _PHRASES.text("LOST_CONTACT")
_NO_MOTION = _PHRASES.pattern("NO_MOTION")

NAMES: tuple[tuple[Motion, str], ...] = (
    (Motion.COUNTERCLOCKWISE, _PHRASES.text("COUNTERCLOCKWISE")),
    (Motion.CLOCKWISE, _PHRASES.text("CLOCKWISE")),
    (Motion.NONE, _PHRASES.text("NONE")),
    (Motion.STILL, _PHRASES.text("STILL")),
    (Motion.RELEASE, _PHRASES.text("RELEASE")),
    (Motion.PRESS, _PHRASES.text("PRESS")),
    (Motion.LEFT, _PHRASES.text("LEFT")),
    (Motion.RIGHT, _PHRASES.text("RIGHT")),
    (Motion.UP, _PHRASES.text("UP")),
    (Motion.DOWN, _PHRASES.text("DOWN")),
)
"""In the order they are looked for; what is found is taken out, so that "counterclockwise" names no
clockwise turn and "pressing down" no slide."""

_OFTEN_MISTYPED = _PHRASES.words("OFTEN_MISTYPED")

ALIKE = 0.85
"""Similarity from which a word may be a mistyped other one: of "pressing" without an s it is 0.93,
of "shifting" and "lifting" 0.80."""


def motions_named(text: str) -> set[Motion]:
    """Return every motion that `text` names."""
    return set(_named(normalised_text(text)))


@lru_cache(maxsize=KEPT)
def _named(text: str) -> frozenset[Motion]:
    text = _NO_MOTION.sub(" ", text)
    found = set()
    for motion, words in NAMES:
        text, count = re.subn(words, " ", text)
        if count:
            found.add(motion)
    return frozenset(found)


def claimed_motion(text: str) -> Motion | None:
    """Return the one motion that `text` names; None if it names none, or several."""
    named = motions_named(text)
    return named.pop() if len(named) == 1 else None


def nearly_named(text: str) -> bool:
    """Tell whether a word of `text` may be a mistyped motion, such as "clokwise"."""
    words = re.findall(r"[a-z]+", _NO_MOTION.sub(" ", text.lower()))
    return any(get_close_matches(word, _OFTEN_MISTYPED, 1, ALIKE) for word in words)
