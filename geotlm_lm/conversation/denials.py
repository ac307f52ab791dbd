"""Denials in other words than "not": "anything but a turn", "it can't be moving, can it?"."""

from __future__ import annotations

import re

_OTHER_THAN = re.compile(
    r"\b(?:(?P<is>is|was) (?P<who>it|this|that|(?:the|my) \w+) )?(?:doing )?"
    r"(?:any|every|some)thing (?:but|except(?: for)?|other than|else than) ",
    re.IGNORECASE,
)
_CANNOT = re.compile(
    r"\b(?P<who>it|this|that|(?:the|my) \w+) (?:can't|cannot|can not|couldn't|could not)"
    r"(?: possibly)? (?:be|have been) (?P<what>[^?]+?),? (?:can|could) (?:it|that)\b",
    re.IGNORECASE,
)


def plainly_denied(question: str) -> str:
    """Return `question` with a "not" in place of what means one; any other text as it is."""
    text = question.replace("\u2019", "'")
    denied = _CANNOT.sub(r"\g<who> is not \g<what>, is it", text)
    denied = _OTHER_THAN.sub(
        lambda said: f"{said['is']} {said['who']} not " if said["is"] else "not ", denied
    )
    return question if denied == text else denied
