"""Derive the direction of one half of the contact from the motion.

In a turn each half goes another way; in a slide all go alike.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from geotlm_lm.conversation.motion_claims import asks_yes_or_no
from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.motion_verbs import GOES, forms
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, reverse

_PHRASES = Phrases("half_directions")
Half = Literal["upper", "lower", "left", "right"]

_CLOCKWISE: dict[Half, Motion] = {
    "upper": Motion.RIGHT,
    "right": Motion.DOWN,
    "lower": Motion.LEFT,
    "left": Motion.UP,
}
"""Which way a half goes in a clockwise turn."""

_HALVES: dict[Half, str] = {
    "upper": _PHRASES.text("UPPER"),
    "lower": _PHRASES.text("LOWER"),
    "left": _PHRASES.text("LEFT"),
    "right": _PHRASES.text("RIGHT"),
}
_OF_WHAT = _PHRASES.text("OF_WHAT")
_GOES = forms(GOES)
_ASKED = tuple(
    (
        half,
        re.compile(
            rf"\b(?:(?:which|what) (?:way|direction)|where) (?:does|did|is|was) (?:the|its) {words}"
            rf"{_OF_WHAT} {_GOES}\W*$"
        ),
    )
    for half, words in _HALVES.items()
)
_CLAIMED = tuple(
    (
        half,
        re.compile(
            rf"\b(?:does|did|is|was) (?:the|its) {words}{_OF_WHAT} (?:slide|sliding|{_GOES})"
            r"(?P<way>(?: to| towards?)?(?: the)? (?:left|right|up|down|top|bottom)(?:wards?)?)\W*$"
        ),
    )
    for half, words in _HALVES.items()
)


@dataclass(frozen=True)
class HalfClaim:
    """A claim that one half of the contact moves in one direction.

    Args:
        half: Which one.
        way: A slide.
    """

    half: Half
    way: Motion

    @property
    def motions(self) -> frozenset[Motion]:
        """The motions in which it does."""
        return frozenset(one for one in Motion if direction_of_half(self.half, one) == self.way)


def direction_of_half(half: Half, motion: Motion) -> Motion | None:
    """Return the direction of a half in a turn or a slide; None in other motions."""
    if motion in ROTATIONS:
        way = _CLOCKWISE[half]
        return way if motion is Motion.CLOCKWISE else reverse(way)
    return motion if motion in SLIDES else None


def asked_half(question: str) -> Half | None:
    """Return the half whose direction `question` asks for; None if none."""
    text = normalised_text(question)
    return next((half for half, words in _ASKED if words.search(text)), None)


def claimed_half(question: str) -> HalfClaim | None:
    """Return the claim of a yes-or-no question about one half; None if there is none."""
    text = normalised_text(question)
    if not asks_yes_or_no(text):
        return None
    for half, words in _CLAIMED:
        said = words.search(text)
        way = said and claimed_motion(said["way"])
        if way:
            return HalfClaim(half, way)
    return None
