"""How far off an accuracy, or a difference of two, could be: clips of one object hang together.

Objects are resampled as wholes; a prediction of None (no usable answer) is wrong, never left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.rows import Row
from geotlm_lm.core.numbers import Labels, group_codes

DRAWS = 4000
"""Bootstrap resamples; a 2.5 % quantile then has a relative error of its rank of about 10 %."""

NORMAL_95 = 1.959963984540054
"""97.5 % quantile of the normal distribution."""


def clustered_interval(
    values: NDArray[Any], objects: Labels, *, seed: int = 0
) -> tuple[float, float]:
    """Return the 95 % interval of an accuracy, resampling whole objects.

    Resampling cannot show doubt where objects agree, and not at all with one object; the interval
    is therefore never narrower, at either end, than Wilson's for as many independent clips.

    Args:
        values: Whether each clip was answered right.
        objects: The object of each clip.
        seed: Root of the resampling.
    """
    values = np.asarray(values, dtype=float)
    low, high = np.quantile(_resampled_means(values, objects, seed), [0.025, 0.975])
    wilson_low, wilson_high = wilson_interval(float(values.mean()), len(values))
    return min(float(low), wilson_low), max(float(high), wilson_high)


def share_row(
    case: str,
    variant: str,
    right: Sequence[bool] | NDArray[np.bool_],
    families: Labels,
    seed: int = 0,
    **fields: Any,
) -> Row:
    """Return a row of the share of wrong answers and its 95 % interval.

    Args:
        case: What was asked about.
        variant: What was asked.
        right: Whether each answer is right.
        families: What is resampled as a whole, one per answer.
        seed: Root of the resampling.
        fields: Further fields of the row.
    """
    right = np.asarray(right)
    low, high = clustered_interval(right, families, seed=seed)
    error, interval = 1 - float(right.mean()), (1 - high, 1 - low)
    return Row(case, variant, len(right), error, interval=interval, **fields)


class Tally:
    """Answers that were right or wrong, by case and variant in order of appearance."""

    def __init__(self) -> None:
        self.found: dict[tuple[str, str], list[tuple[bool, str]]] = {}

    def add(self, case: str, variant: str, is_right: bool, family: str) -> None:
        """Count an answer; `family` is what is resampled as a whole."""
        self.found.setdefault((case, variant), []).append((is_right, family))

    def rows(self, seed: int) -> list[Row]:
        """Return the shares of wrong answers, one row per case and variant."""
        told = self.found.items()
        return [share_row(*key, *zip(*graded, strict=True), seed) for key, graded in told]


def wilson_interval(share: float, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share of `count` independent clips."""
    z2 = NORMAL_95**2
    centre = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = NORMAL_95 / (1 + z2 / count)
    half *= np.sqrt(share * (1 - share) / count + z2 / (4 * count**2))
    return max(float(centre - half), 0.0), min(float(centre + half), 1.0)


def paired_difference(
    first: NDArray[Any], second: NDArray[Any], objects: Labels, *, seed: int = 0
) -> dict[str, float]:
    """Return the difference of two accuracies with its 95 % interval, objects kept whole.

    Args:
        first: Whether the first method was right, one per clip.
        second: Whether the second was.
        objects: The object of each clip.
        seed: Root of the resampling.
    """
    gain = np.asarray(first, dtype=float) - np.asarray(second, dtype=float)
    if len(set(objects)) == 1:  # one object tells nothing of others
        return {"difference": float(gain.mean()), "low": -1.0, "high": 1.0}
    low, high = np.quantile(_resampled_means(gain, objects, seed), [0.025, 0.975])
    return {"difference": float(gain.mean()), "low": float(low), "high": float(high)}


def milliseconds(values: Sequence[float]) -> dict[str, float]:
    """Return the median and the 95th percentile, by the names of a row's fields."""
    return {"ms_p50": float(np.median(values)), "ms_p95": float(np.quantile(values, 0.95))}


def _resampled_means(values: NDArray[Any], objects: Labels, seed: int) -> NDArray[np.float64]:
    codes, names = group_codes(objects)
    sums = np.bincount(codes, weights=values, minlength=len(names))
    sizes = np.bincount(codes, minlength=len(names))
    chance = np.full(len(names), 1 / len(names))
    counts = np.random.default_rng(seed).multinomial(len(names), chance, size=DRAWS)
    return (counts @ sums) / (counts @ sizes)
