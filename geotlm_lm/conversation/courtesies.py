"""Strip what surrounds a question and asks nothing: greetings, excuses, "over"."""

from __future__ import annotations

import re

_GREETING = (
    r"(?:hi|hello|hey)(?: there| again| all)?|good (?:morning|afternoon|evening|day)|dear \w+"
    r"|(?:sorry|excuse me|pardon me)(?: (?:to|for) (?:bother|interrupt|disturb|ask)\w*"
    r"(?: (?:you|this|again))*)?|(?:many )?thanks(?: a lot| so much)?"
    r"|thank you(?: (?:so|very) much)?|um+|uh+|hm+|roger(?: that)?|copy(?: that)?"
    r"|(?:just )?one (?:more|last|other|final|quick) (?:thing|question)|quick (?:one|check)"
)
_OPENS = re.compile(rf"^(?:(?:{_GREETING})(?:[,:;.!]+| -+)? +(?:but |and )?)+(?=\S)", re.IGNORECASE)
_NOTHING_ELSE = re.compile(rf"(?:(?:{_GREETING})[ ,:;.!?-]*)+", re.IGNORECASE)
_FILLER = re.compile(r"(?<=\w),? \b(?:um+|uh+|erm+)\b,?(?= )", re.IGNORECASE)
_YES_NO = re.compile(r"[,:]? yes,? no(?=[ .!?]*$)", re.IGNORECASE)
"""No denial: "is it slipping yes no"."""

_CLOSES = re.compile(
    r"(?:[,;]? (?:by any chance|if you (?:don't|do not) mind|thanks in advance|question mark"
    r"|if i may ask)|[,;] over(?: and out)?)+(?P<mark>[ .!?]*)$",
    re.IGNORECASE,
)


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
