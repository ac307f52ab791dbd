"""Patterns of words within and around a question that do not change its meaning."""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("question_affixes")
JUST = _PHRASES.text("JUST")
WHETHER = _PHRASES.text("WHETHER")
TAIL = _PHRASES.text("TAIL")
