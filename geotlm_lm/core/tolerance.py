"""When an amount that is told counts as right: for answers, training and benchmarks alike."""

from __future__ import annotations

from typing import Literal

TOLERANCES = {"deg": 2.0, "mm": 0.2, "px": 2.0}
"""Least error of an amount that still counts as right, by unit; a fifth of the true amount does.
Pixels are those of the 224-pixel image: 0.2 mm are 2.2 of them on a GelSight Mini."""

RELATIVE_TOLERANCE = 0.2


def within_tolerance(amount: float, true: float, unit: Literal["deg", "mm", "px"]) -> bool:
    """Tell whether an amount is right: off by 2 degrees, 0.2 mm or 2 px, or by a fifth, at most."""
    return abs(amount - true) <= max(TOLERANCES[unit], RELATIVE_TOLERANCE * true)
