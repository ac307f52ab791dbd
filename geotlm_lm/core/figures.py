"""Digits of amounts in words, tables and plots: two, from 100 up three."""

from __future__ import annotations

import math


def rounded(value: float) -> float:
    """Return an amount with these digits."""
    return float(f"{value:.{_digits(value)}g}")


def rounded_up(value: float) -> float:
    """Return the least number of as many digits that is not less."""
    if value == 0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - _digits(value))
    return float(f"{math.ceil(value / step - 1e-9) * step:.3g}")


def figure_of(value: float) -> str:
    """Return an amount as text with these digits, without a power of ten."""
    return f"{rounded(value):.10g}"


def _digits(value: float) -> int:
    return 3 if abs(value) >= 100 else 2
