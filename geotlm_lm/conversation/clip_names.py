"""Recognise references to one of two clips: "the first one", "clip 2", "B"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_claims import offered_options
from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("clip_names")
CLIP = _PHRASES.group("CLIP")
_PLACE = _PHRASES.group("PLACE")
_NUMBER = _PHRASES.group("NUMBER")
_FIRST = ("first", "1st", "1", "one")


_ALONE = _PHRASES.pattern("ALONE")
_B = _PHRASES.pattern("B")
_A = _PHRASES.pattern("A")
_OPENING_A = re.compile(r"^A\b")
"""An article, unless a B is named too."""


def clip_named(group: str) -> str:
    """Return a pattern of a clip by its place or number, which is the group of this name.

    For where the words around it leave no doubt that a clip is meant.
    """
    return rf"(?:the )?(?:{CLIP} )?(?P<{group}>{_PLACE}|{_NUMBER})(?: {CLIP})?(?:'s\b)?"


def place_of(word: str) -> int:
    """Return which clip, 0 or 1, a word for its place or number names."""
    return int(word not in _FIRST)


def named_alone(text: str) -> re.Match[str] | None:
    """Return where `text`, in lower case, names one clip and no other; None elsewhere.

    The group `own` holds the "'s" of "the second one's direction".
    """
    found = list(_ALONE.finditer(text))
    return found[0] if len(found) == 1 else None


def place_named(named: re.Match[str]) -> int:
    """Return which clip, 0 or 1, `named_alone` has found."""
    return place_of(named["number"] or named["place"] or named["asked"])


def clips_by_number(question: str) -> str:
    """Replace "A" and "B", as names of two clips, by first and second."""
    if question.isupper() or offered_options(question):
        return question
    text = _B.sub("the second one", question)
    if text != question:
        text = _OPENING_A.sub("the first one", text)
    return _A.sub("the first one", text)
