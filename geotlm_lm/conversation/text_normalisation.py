"""Normalise a text for the rules: lower case, plain apostrophes, single spaces."""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("text_normalisation")
_OPENERS = _PHRASES.pattern("OPENERS")


def normalised_text(text: str) -> str:
    """Return `text` in the form that every rule on words expects."""
    return " ".join(text.lower().replace("\u2019", "'").split())


def without_openers(text: str) -> str:
    """Return `text` normalised, from its first word that belongs to the question.

    "So, ok, which way?" is "which way?"; a text of openers alone keeps its last.
    """
    plain = normalised_text(text)
    return plain[_OPENERS.match(plain).end() :]
