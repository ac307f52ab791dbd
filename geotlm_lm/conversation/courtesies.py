"""Strip what surrounds a question and asks nothing: greetings, excuses, "over"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("courtesies")
_OPENS = _PHRASES.pattern("OPENS", re.IGNORECASE)
_NOTHING_ELSE = _PHRASES.pattern("NOTHING_ELSE", re.IGNORECASE)
_FILLER = _PHRASES.pattern("FILLER", re.IGNORECASE)
_YES_NO = _PHRASES.pattern("YES_NO", re.IGNORECASE)
_CLOSES = _PHRASES.pattern("CLOSES", re.IGNORECASE)


def without_courtesies(text: str) -> str:
    """Strip greetings and the like around a question; a text of nothing else stays.

    What models have read around questions ("please", "just asking") stays.
    """
    if _NOTHING_ELSE.fullmatch(text):
        return text
    rest = _YES_NO.sub(", yes or no", _FILLER.sub("", _OPENS.sub("", text)))
    closed = _CLOSES.search(rest)
    if closed is None:
        return rest
    mark = closed["mark"].strip() or ("?" if "question mark" in closed[0].lower() else "")
    return f"{rest[: closed.start()]}{mark}"
