"""Amounts that a yes-or-no question claims: "did it turn 45 degrees?", "more than 3 mm?"."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

Bound = Literal["about", "more", "less"]


@dataclass(frozen=True)
class StatedAmount:
    """An amount a question claims.

    Args:
        value: In `unit`.
        unit: "deg", "px" or "mm".
        bound: Whether it went about so far, further, or less far.
    """

    value: float
    unit: str
    bound: Bound

    def holds(self, amount: float, tolerance: float) -> bool:
        """Tell whether the claim is true of an amount, both in the same unit.

        Args:
            amount: How far it went.
            tolerance: How far off an amount may be to count as the same.
        """
        if self.bound == "about":
            return abs(amount - self.value) <= tolerance
        return (amount > self.value) == (self.bound == "more")


_YES_OR_NO = re.compile(
    r"(?:^|[,;:.!] |\b(?:and|so|but|hey|ok|please|now) )"
    r"(?:is|are|was|were|does|do|did|has|have|had)(?:n't)? (?!you\b)|^(?:more|less|over|under)\b"
)
_MEASURED = re.compile(
    r"(?<![\w.])(?P<number>\d+(?:\.\d+)?|\.\d+|half an?) ?"
    r"(?P<unit>degrees?\b|deg\b|°|mm\b|millimet(?:er|re)s?\b|px\b|pixels?\b)"
    r"(?! ?(?:per|/|a) )(?! or\b)"
)
_TURNS = (
    (r"\bthree[ -]quarters? (?:of a |of one )?(?:turn|revolution|rotation|circle)\b", 270.0),
    (r"\bquarter (?:of a |of one )?(?:turn|revolution|rotation|circle)\b", 90.0),
    (r"\bhalf (?:of )?(?:a |one )?(?:turn|revolution|rotation|circle)\b", 180.0),
    (
        r"\b(?:(?:one|a|the) )?(?:full|whole|complete|entire) (?:turn|revolution|rotation|circle)\b"
        r"|\ball the way (?:a)?round\b",
        360.0,
    ),
)
_MORE = re.compile(
    r"\b(?:more than|over|at least|above|beyond|exceed\w*|further than|farther than)\b"
)
_LESS = re.compile(r"\b(?:less than|under|at most|below|no more than|within)\b")


def stated_amount(question: str) -> StatedAmount | None:
    """Return the amount a yes-or-no question claims; None where it claims none, or several."""
    text = " ".join(question.lower().split())
    if not _YES_OR_NO.search(text):
        return None
    found = [
        (_number(said["number"]), _unit(said["unit"])) for said in _MEASURED.finditer(text)
    ] or [(turn, "deg") for words, turn in _TURNS if re.search(words, text)]
    if len(found) != 1:
        return None
    bound: Bound = "less" if _LESS.search(text) else "more" if _MORE.search(text) else "about"
    return StatedAmount(*found[0], bound)


def without_amount(question: str) -> str:
    """Return a question without the amounts it states, which name no motion."""
    text = _MEASURED.sub(" ", question.lower())
    for words, _ in _TURNS:
        text = re.sub(words, " ", text)
    return text


def _number(word: str) -> float:
    return 0.5 if word.startswith("half") else float(word)


def _unit(word: str) -> str:
    if word.startswith(("deg", "°")):
        return "deg"
    return "px" if word.startswith("p") else "mm"
