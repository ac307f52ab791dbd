"""A text as the rules match it: in lower case, with plain apostrophes and single spaces."""

from __future__ import annotations

import re

_OPENERS = re.compile(
    r"\W*(?:(?:and|so(?! (?:far|much|many|long)\b)|ok|okay|now|but|hey|please|well|then)[,:.!]? +)*"
)


def plain_text(text: str) -> str:
    """Return `text` as every rule on words reads it."""
    return " ".join(text.lower().replace("\u2019", "'").split())


def without_openers(text: str) -> str:
    """Return `text` as the rules on whole texts read it: plain, and from its first word that asks.

    "So, ok, which way?" is "which way?"; a text of openers alone keeps its last.
    """
    plain = plain_text(text)
    return plain[_OPENERS.match(plain).end() :]
