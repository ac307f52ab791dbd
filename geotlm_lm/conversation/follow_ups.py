"""Complete short follow-up questions from the one before: "and the object?", "and now?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import HOLDER
from geotlm_lm.conversation.kinds import asked_amount, asked_kind
from geotlm_lm.conversation.motion_claims import asks_yes_or_no, presumed_class
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers
from geotlm_lm.conversation.wording import decapitalised
from geotlm_lm.core.labels import MotionClass

_PHRASES = Phrases("follow_ups")
_OF_ANOTHER = _PHRASES.pattern("OF_ANOTHER")
_NOW = _PHRASES.pattern("NOW")
_WHERE = _PHRASES.pattern("WHERE")
_ASKS_ITSELF = _PHRASES.pattern("ASKS_ITSELF")
_ASKS = {"magnitude": "How far does {} move?", "rate": "How fast does {} move?"}
_VERBS = {MotionClass.ROTATION: "turn", MotionClass.SLIDE: "slide"}
_CHANGES = ("mirrored", "reversed", "viewpoint")
"""Kinds that change how the motion is seen, and which motion is asked about not at all."""


def follow_up_of(question: str, before: str | None) -> str:
    """Return a follow-up that names only what it is about as a whole question.

    "And the object?" asks of the object what was asked of the sensor: how far, how fast, or else
    which way. Of what holds the sensor it asks which way alone: it goes as
    far as the object does. "And mirrored?" after a question about the turn, or the slide, asks of
    that one. Any other question stays as it is.
    """
    said = _OF_ANOTHER.fullmatch(normalised_text(question))
    verb = None if before is None else _VERBS.get(presumed_class(before))
    if said is None:
        if verb is None or not _only_changes(question):
            return question
        return f"Which way does it {verb}: {decapitalised(question)}"
    is_of_it = before is not None and not re.search(rf"\b{HOLDER}$", said["who"])
    kind = asked_amount(before) if is_of_it else None
    return _ASKS.get(kind, f"Which way does {{}} {verb or 'move'}?").format(said["who"])


def _only_changes(question: str) -> bool:
    """Tell whether a question is no more than a change: "and mirrored?"."""
    text = normalised_text(question)
    if asked_kind(question) not in _CHANGES or _ASKS_ITSELF.search(text):
        return False
    return not asks_yes_or_no(text) and presumed_class(question) is None


def asks_where(question: str) -> bool:
    """Tell whether `question` is no more than "where?"."""
    return bool(_WHERE.fullmatch(without_openers(question)))


def asks_again_now(question: str) -> bool:
    """Tell whether `question` repeats the one before as of now: "and now?"."""
    return bool(_NOW.fullmatch(normalised_text(question)))
