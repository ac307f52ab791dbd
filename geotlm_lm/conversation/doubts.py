"""Which motion a question about certainty is of: "is it likely that it turns clockwise?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.claims import claimed
from geotlm_lm.conversation.plain_text import plain_text
from geotlm_lm.core.labels import Motion

_DENIED = re.compile(r"n't\b|\b(?:not|never|no longer)\b")


def doubted(question: str) -> frozenset[Motion] | None:
    """Return the motions of which `question` asks how likely they are; None if it names none.

    None too where it denies them: how likely the rest is, is then asked of the answer before.
    """
    denies = _DENIED.search(plain_text(question))
    return None if denies else claimed(f"Is it so: {question}")
