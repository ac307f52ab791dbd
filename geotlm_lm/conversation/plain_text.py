"""A text as the rules match it: in lower case, with plain apostrophes and single spaces."""

from __future__ import annotations


def plain_text(text: str) -> str:
    """Return `text` as every rule on words reads it."""
    return " ".join(text.lower().replace("\u2019", "'").split())
