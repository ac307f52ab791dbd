"""Recognise suppositions about the clip or the mover; each changes signs only.

A question may suppose several at once, "mirrored and played backwards": they are composed, so that
none is told as if it were the only one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal

from geotlm_lm.conversation.kind_phrases import RULES
from geotlm_lm.conversation.kind_words import HOLDER
from geotlm_lm.conversation.motion_claims import asks_yes_or_no, claimed_motions
from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, mirror, reverse, turn_by_quarter

_PHRASES = Phrases("hypothetical_changes")
Change = Literal["undo", "turned", "vertical", "mirrored", "reversed", "viewpoint", "actor"]

_MOVE = _PHRASES.text("MOVE")
_MOTION = _PHRASES.group("MOTION")
_NO_PLACE = _PHRASES.text("NO_PLACE")


def _moves(holder: str) -> re.Pattern[str]:
    """Return what says that a holder moves, or is to be moved."""
    holder = rf"(?:the|my) {holder}\b"
    then = r"(?: (?:itself|should|must|would|has to|needs to|is|was|to))*"
    return re.compile(
        rf"\b{_MOVE} {holder}|\b{_MOTION} of {holder}|{_NO_PLACE}{holder}{then} {_MOVE}\b"
    )


_SURE_HOLDER = _PHRASES.group("SURE_HOLDER")

_HOLDER_MOVES, _FINGER_MOVES = _moves(_SURE_HOLDER), _moves(HOLDER)

_SHOWN = _PHRASES.pattern("SHOWN")

_WORDS: tuple[tuple[Change, re.Pattern[str]], ...] = tuple(
    (name, re.compile(words))
    for name, words in (
        ("turned", _PHRASES.text("TURNED")),
        ("vertical", _PHRASES.text("FLIPPED_VERTICALLY")),
        *((kind, "|".join(RULES[kind])) for kind in ("undo", "mirrored", "reversed", "viewpoint")),
        ("actor", "|".join(rule.replace(HOLDER, _SURE_HOLDER) for rule in RULES["actor"])),
    )
)
"""In the order they are looked for; what is found is taken out."""

_SHOULD_I = _PHRASES.pattern("SHOULD_I")
_ACT = _PHRASES.pattern("ACT")
_WHICH = _PHRASES.pattern("WHICH")


@dataclass(frozen=True)
class Changes:
    """Changes of a clip or its mover that a question supposes together."""

    names: frozenset[Change]

    def of(self, motion: Motion) -> Motion:
        """Return the motion that a changed clip shows, or that undoes the one it shows."""
        for name in self.names & _ON_MOTIONS.keys():
            motion = _ON_MOTIONS[name](motion)
        return motion

    def frame(self, frame: FrameSpec) -> FrameSpec:
        """Return the frame a changed motion is told in."""
        if "viewpoint" in self.names:
            frame = replace(frame, viewpoint="object")
        if "turned" in self.names:
            frame = replace(frame, **FrameSpec.fields_of_turn(180 + frame.turn_deg))
        return replace(frame, actor="sensor") if "actor" in self.names else frame

    def in_words(self) -> str:
        """Return how the clip is changed, as the end of a sentence; "" where it is as it is."""
        supposed = [words for name, words in _SUPPOSED.items() if name in self.names]
        if supposed == [_SUPPOSED["reversed"]]:
            return f", {supposed[0]}"
        return f", if the clip is {' and '.join(supposed)}" if supposed else ""


_SUPPOSED: dict[Change, str] = {
    "mirrored": "mirrored",
    "vertical": "flipped top to bottom",
    "reversed": "played backwards",
}


_ON_MOTIONS = {
    "mirrored": mirror,
    "vertical": lambda motion: mirror(turn_by_quarter(turn_by_quarter(motion))),
    "reversed": reverse,
    "undo": reverse,
}
"""All of them change signs alone, so that their order does not matter."""


def supposed_changes(question: str, kind: Change) -> Changes:
    """Return the changes that a question of `kind` supposes together.

    Args:
        question: What was asked.
        kind: What it is a question of.
    """
    text = _SHOWN.sub(" ", normalised_text(question))
    moves = _FINGER_MOVES if kind == "undo" else _HOLDER_MOVES
    names: set[Change] = {"actor"} if moves.search(text) else set()
    for name, words in _WORDS:
        text, count = words.subn(" ", text)
        if count:
            names.add(name)
    is_told_how = kind == "mirrored" and names & {"turned", "vertical"}
    return Changes(frozenset(names if is_told_how else names | {kind}))


def claimed_inverse(question: str) -> Motion | None:
    """Return the motion that a yes-or-no question claims to undo another; else None."""
    text = _ACT.sub(" ", normalised_text(question))
    asks = asks_yes_or_no(text) or _SHOULD_I.search(text)
    return claimed_motion(text) if asks and not _WHICH.search(text) else None


def claims_on_changed_clip(question: str) -> frozenset[Motion]:
    """Return the motions that a yes-or-no question claims of the changed clip, if any.

    "If the image were mirrored, would it slide left?"
    """
    text = normalised_text(question)
    if not asks_yes_or_no(text) or _WHICH.search(text):
        return frozenset()
    for _, words in _WORDS:
        text = words.sub(" ", text)
    return claimed_motions(f"Is it so: {text}") or frozenset()
