"""Parse amounts that a yes-or-no question claims: "did it turn 45 degrees?"."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.motion_claims import asks_yes_or_no
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.non_tactile_questions import asks_beyond_touch
from geotlm_lm.conversation.number_words import NUMBER
from geotlm_lm.conversation.object_sizes import without_sizes
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.quantities import Quantity, quantities, without_quantities
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("stated_amounts", NUMBER=NUMBER)
Bound = Literal["about", "more", "less"]

UNJUDGED = (
    "I cannot judge that number: I judge how far or how fast it turned or slid, one amount or one "
    "range at a time; ask for example 'did it turn 10 to 20 degrees?'."
)
"""Said in place of a yes or no that would pass over the number."""


@dataclass(frozen=True)
class StatedAmount:
    """An amount a question claims.

    Args:
        value: In `unit`.
        unit: "deg", "px" or "mm"; "deg/s" and so on of a speed.
        bound: Whether it went about so far, further, or less far.
    """

    value: float
    unit: str
    bound: Bound

    @property
    def is_speed(self) -> bool:
        """Whether it is one per second."""
        return "/" in self.unit

    @property
    def ends(self) -> tuple[float, ...]:
        """What a tolerance is of."""
        return (self.value,)

    def holds(self, amount: float, tolerance: float) -> bool:
        """Tell whether the claim is true of an amount, both in the same unit.

        Args:
            amount: How far it went.
            tolerance: How far off an amount may be to count as the same.
        """
        if self.bound == "about":
            return abs(amount - self.value) <= tolerance
        return (amount > self.value) == (self.bound == "more")


@dataclass(frozen=True)
class StatedRange:
    """A range that a question claims the amount to lie in.

    Args:
        low: In `unit`.
        high: Likewise.
        unit: As of a `StatedAmount`.
    """

    low: float
    high: float
    unit: str

    @property
    def is_speed(self) -> bool:
        """Whether it is one per second."""
        return "/" in self.unit

    @property
    def ends(self) -> tuple[float, ...]:
        """What the tolerances are of."""
        return self.low, self.high

    def holds(self, amount: float, below: float, above: float) -> bool:
        """Tell whether the claim is true of an amount, both in the same unit.

        Args:
            amount: How far it went.
            below: How far under the range an amount may be to count as in it.
            above: How far over it.
        """
        return self.low - below <= amount <= self.high + above


Stated = StatedAmount | StatedRange

_COMPARES = _PHRASES.pattern("COMPARES")
_NOTHING_ELSE = _PHRASES.pattern("NOTHING_ELSE")
_TELLS = _PHRASES.pattern("TELLS")
_BOUND = _PHRASES.pattern("BOUND")
_BOUND_AFTER = _PHRASES.pattern("BOUND_AFTER")
_OF_MOTION = _PHRASES.pattern("OF_MOTION")
_OF_ANOTHER_THING = _PHRASES.pattern("OF_ANOTHER_THING")
_OF_SPEED = _PHRASES.pattern("OF_SPEED")
_BARE = _PHRASES.pattern("BARE")
_OF_TIME = _PHRASES.pattern("OF_TIME")
_OF_A_PIXEL = _PHRASES.pattern("OF_A_PIXEL")
_DENIAL = _PHRASES.pattern("DENIAL")

_UNCOUNTED = ("comparison", "order", "confidence")
"""Kinds that are of several clips or of an answer before, whatever number they name."""


def claimed_amount(question: str) -> Stated | None:
    """Return how far, or how fast, a yes-or-no question claims that it went; None if it does not.

    None too where it claims several amounts, or one of another thing than a motion.
    """
    return stated_amount(question) or stated_range(question) or stated_speed(question)


def stated_amount(question: str) -> StatedAmount | None:
    """Return the one amount that a question claims in all; None where it claims none such."""
    stated = _stated(question)
    is_one = isinstance(stated, StatedAmount) and not stated.is_speed
    return stated if is_one else None


def stated_range(question: str) -> StatedRange | None:
    """Return the range in which a question claims an amount or a speed; None if in none."""
    stated = _stated(question)
    return stated if isinstance(stated, StatedRange) else None


def stated_speed(question: str) -> StatedAmount | None:
    """Return the one speed that a question claims; None where it claims none."""
    stated = _stated(question)
    is_one = isinstance(stated, StatedAmount) and stated.is_speed
    return stated if is_one else None


def claims_unread_amount(question: str) -> bool:
    """Tell whether a yes-or-no question claims a number that is no `claimed_amount`."""
    text = _text(question)
    if claimed_amount(question) is not None or asked_kind(question) in _UNCOUNTED:
        return False
    is_of_motion = _OF_MOTION.search(text) or _COMPARES.match(text)
    named = quantities(text) or (is_of_motion and _BARE.search(text))
    if asks_beyond_touch(text) or not named or (_OF_A_PIXEL.search(text) and not is_of_motion):
        return False
    return _asks(text) or bool(_COMPARES.match(text))


def denies_amount(question: str) -> bool:
    """Tell whether what a question claims of its amount is that it did not go so far."""
    text = _text(question)
    found = quantities(text)
    return bool(found) and len(_DENIAL.findall(text[: found[0].start])) % 2 == 1


def without_amount(question: str) -> str:
    """Return a question without the amounts it states, which name no motion."""
    return without_quantities(_text(question))


def _text(question: str) -> str:
    text = normalised_text(question).replace("\u2212", "-")
    return without_sizes(text.replace("\u00bd", "1/2"))


def _asks(text: str) -> bool:
    return asks_yes_or_no(text) or bool(_TELLS.search(text)) or _is_fragment(text)


def _is_fragment(text: str) -> bool:
    """Tell whether an amount is all that is asked: "about 12 px?"."""
    found = quantities(text)
    is_asked = text.endswith("?") and bool(found)
    return is_asked and bool(_NOTHING_ELSE.fullmatch(text[: found[0].start]))


def _stated(question: str) -> Stated | None:
    text = _text(question)
    found = quantities(text)
    if not found or not all(one.values for one in found) or _OF_ANOTHER_THING.search(text):
        return None
    rest = without_quantities(text)
    is_speed = all("/" in one.unit for one in found)
    if _OF_SPEED.search(text) and not is_speed:
        return None
    if denies_amount(question) and motions_named(rest):
        return None  # which of the two is denied is left open
    is_of_motion = is_speed or _OF_MOTION.search(rest)
    is_asked = asks_yes_or_no(text) or _TELLS.search(text)
    is_left = _is_fragment(text) or _COMPARES.match(text)
    if not ((is_asked and is_of_motion) or is_left) or _OF_TIME.search(text):
        return None
    return _together([_bounded(text, one) for one in found])


def _bounded(text: str, one: Quantity) -> Stated:
    if len(one.values) == 2:
        return StatedRange(*one.values, one.unit)
    before, after = _BOUND.search(text[: one.start]), _BOUND_AFTER.search(text[one.end :])
    bound: Bound = "about"
    if before is not None:
        bound = "more" if before["more"] or before["above"] else "less"
    elif after is not None:
        bound = "more" if after["more"] else "less"
    return StatedAmount(one.values[0], one.unit, bound)


def _together(stated: list[Stated]) -> Stated | None:
    """Return one claim alone, or the range of a lower and an upper bound; None of others."""
    if len(stated) == 1:
        return stated[0]
    bounds = {one.bound: one for one in stated if isinstance(one, StatedAmount)}
    if len(stated) > 2 or bounds.keys() != {"more", "less"}:
        return None
    low, high = bounds["more"], bounds["less"]
    is_range = low.unit == high.unit and low.value < high.value
    return StatedRange(low.value, high.value, low.unit) if is_range else None
