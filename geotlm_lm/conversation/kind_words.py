"""Fragments that the patterns of `kind_phrases` are built from."""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("kind_words")
HOLDER = _PHRASES.group("HOLDER")
PICTURE = _PHRASES.group("PICTURE")
