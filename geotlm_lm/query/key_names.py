"""Find the names that a question gives to the values of its answer: the keys of a JSON object.

Names are found by how they stand, in quotes or one beside the other, whatever the language around.
"""

from __future__ import annotations

import re

_QUOTED = re.compile(r"[\"'`]([A-Za-z_][\w.-]*)[\"'`]")
_NAME = r"[\"'`]?\b(?!and\b)([A-Za-z_]\w*)\b[\"'`]?"
_TYPE = r"(?:\s*:\s*[\w?|.\[\]]*|\s*\([^)]*\))?"
"""What may follow a name: ": float", "(number)", ": ?"."""
_STEP = r"\s*(?:,|;|,?\s+and)\s+|\s*,\s*"
_LIST = re.compile(rf"{_NAME}{_TYPE}(?:(?:{_STEP}){_NAME}{_TYPE})+(?!\s+\w)")
"""Whose last name no other word follows: "magnitude, no markdown" ends at the comma."""
_ITEM = re.compile(rf"(?:^|{_STEP}){_NAME}{_TYPE}")


def key_names(text: str, count: int) -> tuple[str, ...]:
    """Return the names given to so many values; none where not just so many are.

    Args:
        text: The question.
        count: How many values its answer has.
    """
    lists = [tuple(_ITEM.findall(match[0])) for match in _LIST.finditer(text)]
    for names in (*lists, tuple(_QUOTED.findall(text))):
        if len(names) == count and len(set(names)) == count:
            return names
    return ()
