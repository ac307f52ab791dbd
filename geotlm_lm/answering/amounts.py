"""An amount that is told: its value, the span it lies in nine times in ten, and how sure it is."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np

from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE

SPAN_DEVIATIONS = 1.645
"""Deviations either side that hold nine tenths of a bell."""

_WORD = re.compile(r"([\d.]+) (deg|px|mm)")
NAMES = {
    "deg": ("degree", "degrees", "turning"),
    "px": ("pixel", "pixels", "sliding"),
    "mm": ("millimetre", "millimetres", "sliding"),
}
_SHORT = {"deg": ("degree", "degrees"), "px": ("px", "px"), "mm": ("mm", "mm")}


@dataclass(frozen=True)
class Amount:
    """A turn, slide or press between the first and the last frame, or per second.

    Args:
        value: The amount told, in `unit`.
        unit: "deg", "px" of the recording's frames, or "mm"; "deg/s" and so on of a mean speed.
        low: Lower end of the span that holds nine tenths of the probability.
        high: Its upper end.
        probability: That the value is off by no more than an answer may be: 2 degrees, 2 pixels of
            a 224-pixel image, 0.2 mm of a press, or a fifth.
        doing: What goes so far: "turning", "sliding" or "pressing in".
    """

    value: float
    unit: str
    low: float
    high: float
    probability: float
    doing: str = ""

    @property
    def word(self) -> str:
        """The amount as a word, such as "15 deg": the deciding one of how far it went."""
        return f"{self.value:g} {self.unit}"

    @property
    def phrase(self) -> str:
        """The amount within a sentence: "about 12 degrees"."""
        one, many = _SHORT[self.unit]
        return f"about {_written(self.value)} {one if self.value == 1 else many}"

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
        told += " per second on average" if rest else f" of {self.doing or moving}"
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


@dataclass(frozen=True)
class Measure:
    """A measured length or angle as a bell.

    Args:
        mean: In `unit`, not negative.
        deviation: Of it, likewise.
        unit: "deg", "px" of the recording's frames, or "mm".
        tolerance: Least error of an answer that still counts as right, in `unit`.
        doing: What goes so far.
    """

    mean: float
    deviation: float
    unit: str
    tolerance: float
    doing: str

    @property
    def bell(self) -> NormalDist:
        """Its distribution; what is below 0 stands for next to nothing."""
        return NormalDist(self.mean, max(self.deviation, 1e-6))

    def amount(self) -> Amount:
        """Return what is told of it: rounded no coarser than the tolerance, the span outwards."""
        decimals = -math.floor(math.log10(self.tolerance))
        value = round(self.mean, decimals)
        if value <= 0:  # less than a step: to one digit, which is not nothing
            value = float(f"{max(self.mean, 10.0 ** -(decimals + 1)):.1g}")
        step, far = 10.0**-decimals, SPAN_DEVIATIONS * self.deviation
        low = math.floor(max(self.mean - far, 0.0) / step + 1e-9) * step
        high = math.ceil((self.mean + far) / step - 1e-9) * step
        low, high = min(round(low, decimals), value), max(round(high, decimals), value)
        return Amount(value, self.unit, low, high, self.right_within(value), self.doing)

    def right_within(self, value: float) -> float:
        """Return how probable it is that a value is right within the tolerance, or a fifth."""
        low = min(value - self.tolerance, value / (1 + RELATIVE_TOLERANCE))
        high = max(value + self.tolerance, value / (1 - RELATIVE_TOLERANCE))
        return self.bell.cdf(high) - self.bell.cdf(low)


def _two_digits(value: float) -> float:
    return float(f"{value:.2g}")


def _written(value: float) -> str:
    return np.format_float_positional(value, trim="-")
