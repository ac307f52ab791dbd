"""Which motion a question about certainty is of: "is it likely that it turns clockwise?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.claims import claimed
from geotlm_lm.conversation.plain_text import plain_text
from geotlm_lm.core.labels import Motion

_DENIED = re.compile(r"n't\b|\b(?:not|never|no longer)\b")


_OF_THE_ANSWER = re.compile(
    r"\b(?:it|that|this|you|(?:the|your|this|that) answer) (?:is|are|was|were|be) "
    r"(?:right|correct|true|so)\b"
)


def doubted(question: str) -> frozenset[Motion] | None:
    """Return the motions of which `question` asks how likely they are; None if it names none.

    None too where it denies them: how likely the rest is, is then asked of the answer before.
    """
    text = plain_text(question)
    is_of_it = _DENIED.search(text) or _OF_THE_ANSWER.search(text)
    return None if is_of_it else claimed(f"Is it so: {question}")
