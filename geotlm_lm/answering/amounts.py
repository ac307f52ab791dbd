"""Choose one amount and its 90 % interval from the odometer's distribution over amounts.

The odometer weighs a few dozen amounts, each standing for those nearest to it. Which single one is
likeliest says little where three neighbours are nearly as likely; what is told is the amount that
is most probably right within its tolerance, and the span that holds nine tenths of the
probability.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE

SPAN_SHARE = 0.9
"""Probability of the span, of all amounts in its unit."""

POINTS_A_CELL = 8
"""Amounts that stand for all of those in a cell, which is half of a tolerance wide."""

_WORD = re.compile(r"([\d.]+) (deg|px|mm)")
NAMES = {
    "deg": ("degree", "degrees", "turning"),
    "px": ("pixel", "pixels", "sliding"),
    "mm": ("millimetre", "millimetres", "sliding"),
}


@dataclass(frozen=True)
class Amount:
    """A rotation or slide between the first and the last frame, or per second.

    Args:
        value: The amount told, in `unit`.
        unit: "deg", "px" of the recording's frames, or "mm"; "deg/s" and so on of a mean speed.
        low: Lower end of the span that holds nine tenths of the probability.
        high: Its upper end.
        probability: That the value is off by no more than an answer may be: 2 degrees, 2 pixels of
            a 224-pixel image, or a fifth.
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

    def sentence(self, where: str = "") -> str:
        """Return the amount and its span as a sentence, `where` in the recording it is of."""
        unit, *rest = self.unit.split("/")
        one, many, moving = NAMES[unit]
        what = one if self.value == 1 else many
        told = f"About {_written(self.value)} {what}"
        told += " per second on average" if rest else f" of {moving}"
        told += where and f" {where}"
        return f"{told}, likely {_written(self.low)} to {_written(self.high)}."

    def also(self, factor: float, name: str) -> str:
        """Return the amount in another unit, as a sentence.

        Args:
            factor: How many of that unit are one of `unit`.
            name: Of that unit.
        """
        value, low, high = (
            _written(_two_digits(one * factor)) for one in (self.value, self.low, self.high)
        )
        return f"That is {value} {name}, likely {low} to {high}."


def amount_in(word: str | None) -> tuple[float, str] | None:
    """Parse an amount and its unit from a deciding word; None where it is none."""
    said = _WORD.fullmatch(word or "")
    return None if said is None else (float(said[1]), said[2])


def best_amount(
    amounts: tuple[float, ...], shares: NDArray[np.floating], unit: str, tolerance: float
) -> Amount:
    """Return the amount most likely to be right within its tolerance, and its interval.

    Args:
        amounts: Rising; each stands for all that are nearer to it than to its neighbours.
        shares: Probability of each; they sum to 1.
        unit: Of them.
        tolerance: Least error that still counts as right, in `unit`; a fifth of the amount does.
    """
    # What is told is a multiple of a power of ten that is no coarser than the tolerance.
    decimals = -math.floor(math.log10(tolerance))
    step = 10.0**-decimals
    told, hits, edges = _cells(amounts, step, tolerance)
    hit = hits @ shares
    best = np.flatnonzero(hit >= hit.max() - 1e-9)
    # Of several that are right as often the one in the middle is told.
    place = best[len(best) // 2]
    tail = (1 - SPAN_SHARE) / 2
    low, high = np.interp([tail, 1 - tail], np.concatenate([[0], shares.cumsum()]), edges)
    value = round(float(told[place]), decimals)
    # Rounded outwards, so that the span still holds its share; what is told lies in it.
    low = min(round(math.floor(low / step + 1e-9) * step, decimals), value)
    high = max(round(math.ceil(high / step - 1e-9) * step, decimals), value)
    return Amount(value, unit, low, high, float(hit[place]))


@lru_cache(maxsize=8)
def _cells(
    amounts: tuple[float, ...], step: float, tolerance: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return what may be told, how much of each amount's cell that is right of, and the cells.

    Returns:
        Amounts that may be told (told,), shares in [0, 1] (told, amounts), edges (amounts + 1,).
    """
    centres = np.array(amounts)
    middles = (centres[1:] + centres[:-1]) / 2
    first, last = max(2 * centres[0] - middles[0], 0.0), 2 * centres[-1] - middles[-1]
    edges = np.concatenate([[first], middles, [last]])
    told = np.arange(1, math.ceil(last / step) + 1) * step
    inside = (np.arange(POINTS_A_CELL) + 0.5) / POINTS_A_CELL
    true = edges[:-1, None] + np.diff(edges)[:, None] * inside
    allowed = np.maximum(tolerance, RELATIVE_TOLERANCE * true) + 1e-9
    return told, (np.abs(told[:, None, None] - true) <= allowed).mean(axis=-1), edges


def _two_digits(value: float) -> float:
    return float(f"{value:.2g}")


def _written(value: float) -> str:
    return np.format_float_positional(value, trim="-")
