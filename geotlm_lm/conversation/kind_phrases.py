"""Patterns of each kind of question that rules recognise, as data; `kinds` reads them."""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("kind_phrases")
COUNTED = _PHRASES.group("COUNTED")


RULES: dict[str, tuple[str, ...]] = {
    kind: _PHRASES.each(kind)
    for kind in (
        *("thread", "undo", "mirrored", "order", "reversed", "evidence"),
        *("comparison", "confidence", "viewpoint", "actor", "rate", "magnitude"),
    )
}
"""Words that tell each kind, in the order the kinds are tried."""
