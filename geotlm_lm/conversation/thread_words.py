"""Rewrite questions about screwing in or out, opening or closing as "does it tighten?"."""

from __future__ import annotations

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("thread_words")
_OF_A_THREAD = _PHRASES.pattern("OF_A_THREAD")
_WHERE_ONE_IS_KNOWN = _PHRASES.pattern("WHERE_ONE_IS_KNOWN")

_TIGHTER_OR_LOOSER = "Is it tightening or loosening?"


def canonical_thread_question(question: str, is_known: bool) -> str:
    """Rewrite a question about a thread in trained wording; others stay as they are.

    Args:
        question: What is asked.
        is_known: Whether the thread of what is touched has been told.
    """
    text = without_openers(question)
    asks = _OF_A_THREAD.fullmatch(text) or (is_known and _WHERE_ONE_IS_KNOWN.fullmatch(text))
    return _TIGHTER_OR_LOOSER if asks else question
