"""Amounts that a yes-or-no question claims: "did it turn 45 degrees?", "more than 3 mm?"."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from geotlm_lm.conversation.claims import asks_yes_or_no

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


_COMPARES = re.compile(r"^(?:more|less|over|under)\b")
"""A question of which only the comparison is left: "more than 10 degrees?"."""

_MEASURED = re.compile(
    r"(?<![\w.])(?P<number>\d+(?:\.\d+)?|\.\d+|half an?) ?"
    r"(?P<unit>degrees?\b|deg\b|°|mm\b|millimet(?:er|re)s?\b|px\b|pixels?\b)"
    r"(?! ?(?:/|per\b|an? |each\b|every\b|in (?:a|one) second\b|or\b))"
)
_TURNS = (
    (r"\bthree[ -]quarters? (?:of a |of one )?(?:turn|revolution|rotation|circle)\b", 270.0),
    (r"\b(?:a )?quarter (?:of a |of one )?(?:turn|revolution|rotation|circle)\b", 90.0),
    (r"\b(?:a )?half (?:of )?(?:a |one )?(?:turn|revolution|rotation|circle)\b", 180.0),
    (
        r"\b(?:(?:one|a|the) )?(?:full|whole|complete|entire) (?:turn|revolution|rotation|circle)\b"
        r"|\ball the way (?:a)?round\b",
        360.0,
    ),
)
_BOUND = re.compile(
    r"\b(?:(?P<more>(?:no|not) (?:less|fewer) than|at least|more than|over|above|beyond"
    r"|exceed(?:s|ed|ing)?|(?:further|farther) than)"
    r"|(?P<less>(?:no|not) more than|not (?:over|above)|at most|up to|less than|fewer than|under"
    r"|below|within))(?: (?:about|around|roughly|some))? $"
)
"""What stands right before an amount and says on which side of it the truth is claimed to lie."""

_RANGE = re.compile(r"\d(?: ?(?:-|\u2013) ?| (?:to|or|and) )$")

_OF_MOTION = re.compile(
    r"\b(?:turn|rotat|twist|spin|spun|swivel|revol|slid|slip|mov|travel|shift|drag|creep|drift|cover"
    r"|displac)\w*|\b(?:go|goes|gone|went|made?)\b"
)
_OF_ANOTHER_THING = re.compile(
    r"\b(?:wide|width|thick\w*|long|deep|high|tall|large|big|celsius|fahrenheit|diameter|radius"
    r"|press\w*|faster|slower|speed|from the (?:edge|border)|will|would|can|could)\b"
)


def stated_amount(question: str) -> StatedAmount | None:
    """Return how far a yes-or-no question claims that it went; None where it claims no amount.

    None too where it claims several, or an amount of another thing than a motion.
    """
    text = " ".join(question.lower().split())
    is_of_motion = asks_yes_or_no(text) and _OF_MOTION.search(text)
    if not (is_of_motion or _COMPARES.match(text)) or _OF_ANOTHER_THING.search(text):
        return None
    found = [
        (said.start(), _number(said["number"]), _unit(said["unit"]))
        for said in _MEASURED.finditer(text)
    ]
    turns = ((re.search(words, text), turn) for words, turn in _TURNS)
    found = found or [(said.start(), turn, "deg") for said, turn in turns if said]
    if len(found) != 1 or _RANGE.search(text[: found[0][0]]):
        return None
    start, value, unit = found[0]
    said = _BOUND.search(text[:start])
    bound: Bound = "about" if said is None else "more" if said["more"] else "less"
    return StatedAmount(value, unit, bound)


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
