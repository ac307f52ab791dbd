"""How far it went: one amount, and how far off it may be, from the probabilities of many.

The model weighs a few dozen amounts, each standing for those nearest to it. Which single one is
likeliest says little where three neighbours are nearly as likely; what is told is the amount that
is most probably right within its tolerance, and the span that holds nine tenths of the
probability.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.evaluation.answers import RELATIVE_TOLERANCE, TOLERANCES
from geotlm_lm.language.parse_answer import Slots

STEPS = {"deg": 1.0, "mm": 0.1}
"""What told amounts are multiples of, by unit."""

SPAN_SHARE = 0.9
"""Probability of the span, of all amounts in its unit. Measured on the 594 of the card's 619 turns
and slides that are told in the right unit, before its ends were rounded outwards: it holds the true
amount of 0.92 of the turns and 0.91 of the slides."""

POINTS_A_CELL = 40
"""Amounts that stand for all of those an option stands for: shares of a cell to within 0.03."""

_WORD = re.compile(r"([\d.]+) (deg|mm)")
_NAMES = {"deg": ("degree", "degrees", "turning"), "mm": ("millimetre", "millimetres", "sliding")}


@dataclass(frozen=True)
class Amount:
    """How far something turned or slid between the first and the last frame, or in each second.

    Args:
        value: The amount told, in `unit`.
        unit: "deg" or "mm"; "deg/s" or "mm/s" of a mean speed.
        low: Lower end of the span that holds nine tenths of the probability.
        high: Its upper end.
        probability: That the value is off by no more than an answer may be: 2 degrees, 0.2 mm, or a
            fifth.
    """

    value: float
    unit: str
    low: float
    high: float
    probability: float

    @property
    def word(self) -> str:
        """The amount as a word, such as "15 deg": the deciding one of how far it went."""
        return f"{self.value:g} {self.unit}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values; the probability is the answer's confidence."""
        return {"value": self.value, "unit": self.unit, "low": self.low, "high": self.high}

    def per_second(self, seconds: float) -> Amount:
        """Return the mean speed, to two digits, of this amount in so many seconds."""
        value, low, high = (_two_digits(one / seconds) for one in (self.value, self.low, self.high))
        return replace(self, value=value, unit=f"{self.unit}/s", low=low, high=high)

    def sentence(self) -> str:
        """Return the amount and its span as a sentence."""
        unit, *rest = self.unit.split("/")
        one, many, moving = _NAMES[unit]
        what = one if self.value == 1 else many
        told = f"About {_written(self.value)} {what}"
        told += " per second on average" if rest else f" of {moving}"
        return f"{told}, likely {_written(self.low)} to {_written(self.high)}."


def amount_in(word: str | None) -> tuple[float, str] | None:
    """Return the amount of a deciding word and its unit; None where it is none."""
    said = _WORD.fullmatch(word or "")
    return None if said is None else (float(said[1]), said[2])


def likeliest_amount(slots: Slots | None, options: Mapping[str, float]) -> Amount | None:
    """Return the amount that is most probably right, and its span; None where none was named.

    Args:
        slots: What the model said: its unit is kept, and of amounts as probable the one nearest to
            its own is told.
        options: Probability of every answer of that kind, by its deciding word.
    """
    if slots is None or slots.amount is None:
        return None
    said = {word: amount_in(word) for word in options}
    weights = {one[0]: options[word] for word, one in said.items() if one and one[1] == slots.unit}
    total = sum(weights.values())
    if not total:
        return Amount(slots.amount, slots.unit, slots.amount, slots.amount, 0.0)
    amounts = tuple(sorted(weights))
    shares = np.array([weights[amount] for amount in amounts]) / total
    told, hits, edges = _cells(amounts, slots.unit)
    hit = hits @ shares
    best = np.flatnonzero(hit >= hit.max() - 1e-9)
    place = best[np.argmin(np.abs(told[best] - slots.amount))]
    tail = (1 - SPAN_SHARE) / 2
    low, high = np.interp([tail, 1 - tail], np.concatenate([[0], shares.cumsum()]), edges)
    value = float(told[place])
    step = STEPS[slots.unit]
    # Rounded outwards, so that the span still holds its share; what is told lies in it.
    low = min(round(math.floor(low / step + 1e-9) * step, 1), value)
    high = max(round(math.ceil(high / step - 1e-9) * step, 1), value)
    return Amount(value, slots.unit, low, high, float(hit[place] * total))


@lru_cache(maxsize=8)
def _cells(
    amounts: tuple[float, ...], unit: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return what may be told, how much of each option's cell that is right of, and the cells.

    Args:
        amounts: What the options say, rising; each stands for all that are nearer to it than to its
            neighbours.
        unit: Of them.

    Returns:
        Amounts that may be told (told,), shares in [0, 1] (told, options), edges (options + 1,).
    """
    centres = np.array(amounts)
    middles = (centres[1:] + centres[:-1]) / 2
    outer = (centres[0], centres[-1]) if len(centres) == 1 else (middles[0], middles[-1])
    first, last = max(2 * centres[0] - outer[0], 0.0), 2 * centres[-1] - outer[1]
    edges = np.concatenate([[first], middles, [last]])
    step = STEPS[unit]
    told = np.round(np.arange(1, round(last / step) + 1) * step, 1)
    inside = (np.arange(POINTS_A_CELL) + 0.5) / POINTS_A_CELL
    true = edges[:-1, None] + np.diff(edges)[:, None] * inside
    tolerance = np.maximum(TOLERANCES[unit], RELATIVE_TOLERANCE * true) + 1e-9
    return told, (np.abs(told[:, None, None] - true) <= tolerance).mean(axis=-1), edges


def _two_digits(value: float) -> float:
    return float(f"{value:.2g}")


def _written(value: float) -> str:
    return np.format_float_positional(value, trim="-")
