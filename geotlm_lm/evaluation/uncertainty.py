"""How far off an accuracy, or a difference of two, could be: clips of one object hang together.

Objects are resampled or sign-flipped as wholes; numpy only.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.evaluation.scores import Labels, group_codes

DRAWS = 4000
"""Bootstrap resamples; a 2.5 % quantile then has a relative error of its rank of about 10 %."""

EXACT_OBJECTS = 12
"""Up to this many objects every sign pattern (2^12 = 4096) is enumerated instead of sampled."""

NORMAL_95 = 1.959963984540054
"""97.5 % quantile of the normal distribution."""


@dataclass(frozen=True)
class PairedDifference:
    """Accuracy of one method less that of another on the same clips.

    Args:
        difference: Mean of (first right) - (second right).
        low: Lower end of its 95 % interval, objects resampled.
        high: Upper end.
        p_value: Two-sided, from flipping the sign of whole objects.
        mcnemar_p: Two-sided exact McNemar, which takes clips as independent.
    """

    difference: float
    low: float
    high: float
    p_value: float
    mcnemar_p: float


def clustered_interval(
    values: NDArray, objects: Labels, *, seed: int = 0, draws: int = DRAWS
) -> tuple[float, float]:
    """Return the 95 % interval of an accuracy, resampling whole objects.

    Resampling cannot show doubt where objects agree, and not at all with one object; the interval
    is therefore never narrower, at either end, than Wilson's for as many independent clips.

    Args:
        values: Whether each clip was answered right.
        objects: The object of each clip.
        seed: Root of the resampling.
        draws: Number of resamples.
    """
    values = np.asarray(values, dtype=float)
    means = _resampled_means(values, objects, seed, draws)
    low, high = np.quantile(means, [0.025, 0.975])
    wilson_low, wilson_high = wilson_interval(float(values.mean()), len(values))
    return min(float(low), wilson_low), max(float(high), wilson_high)


def wilson_interval(share: float, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share of `count` independent clips."""
    z2 = NORMAL_95**2
    centre = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = NORMAL_95 / (1 + z2 / count)
    half *= np.sqrt(share * (1 - share) / count + z2 / (4 * count**2))
    return max(float(centre - half), 0.0), min(float(centre + half), 1.0)


def paired_difference(
    first: NDArray, second: NDArray, objects: Labels, *, seed: int = 0, draws: int = DRAWS
) -> PairedDifference:
    """Compare two methods clip by clip, objects kept whole.

    Args:
        first: Whether the first method was right, one per clip.
        second: Whether the second was.
        objects: The object of each clip.
        seed: Root of the resampling.
        draws: Number of resamples, and of sign patterns when those are sampled.

    Raises:
        ValueError: If the three do not have the same length.
    """
    if not len(first) == len(second) == len(objects):
        raise ValueError(f"lengths differ: {len(first)}, {len(second)}, {len(objects)}")
    gain = np.asarray(first, dtype=float) - np.asarray(second, dtype=float)
    low, high = np.quantile(_resampled_means(gain, objects, seed, draws), [0.025, 0.975])
    if len(set(objects)) == 1:  # one object tells nothing of others
        low, high = -1.0, 1.0
    return PairedDifference(
        difference=float(gain.mean()),
        low=float(low),
        high=float(high),
        p_value=sign_flip_p(gain, objects, seed=seed, draws=draws),
        mcnemar_p=mcnemar_exact(first, second),
    )


def sign_flip_p(gain: NDArray, objects: Labels, *, seed: int = 0, draws: int = DRAWS) -> float:
    """Return how often flipping whole objects' signs gives as large a total, two-sided.

    Exact for up to `EXACT_OBJECTS` objects; sampled, with the observed pattern counted in, beyond.
    """
    codes, names = group_codes(objects)
    sums = np.bincount(codes, weights=gain, minlength=len(names))
    observed = abs(sums.sum()) - 1e-9
    if len(names) <= EXACT_OBJECTS:
        patterns = np.arange(2 ** len(names))[:, None] >> np.arange(len(names)) & 1
        return float((np.abs((2 * patterns - 1) @ sums) >= observed).mean())
    signs = np.random.default_rng(seed).integers(0, 2, (draws, len(names))) * 2 - 1
    return float((1 + (np.abs(signs @ sums) >= observed).sum()) / (1 + draws))


def mcnemar_exact(first: NDArray, second: NDArray) -> float:
    """Return the two-sided exact McNemar p-value: the binomial test on clips that differ."""
    first, second = np.asarray(first, dtype=bool), np.asarray(second, dtype=bool)
    only_first, only_second = int((first & ~second).sum()), int((~first & second).sum())
    count, smaller = only_first + only_second, min(only_first, only_second)
    tail = sum(comb(count, k) for k in range(smaller + 1))
    # Integers of any size divide exactly here, where a float power of 2 would overflow.
    return min(1.0, 2 * tail / (1 << count))


def _resampled_means(values: NDArray, objects: Labels, seed: int, draws: int) -> NDArray:
    codes, names = group_codes(objects)
    sums = np.bincount(codes, weights=values, minlength=len(names))
    sizes = np.bincount(codes, minlength=len(names))
    chance = np.full(len(names), 1 / len(names))
    counts = np.random.default_rng(seed).multinomial(len(names), chance, size=draws)
    return (counts @ sums) / (counts @ sizes)
