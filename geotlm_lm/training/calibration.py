"""Fit the two numbers that decide how sure an answer is, on objects no weight has seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

TEMPERATURES = np.geomspace(0.25, 8.0, 161)
CONTACT_QUANTILE = 0.005
"""Share of touched clips that may fall below the contact threshold."""


def fit_temperature(log_likelihoods: NDArray[np.floating], truths: NDArray[np.integer]) -> float:
    """Return the temperature under which the true answers are most likely.

    Args:
        log_likelihoods: Log-likelihood of every option, shape (n, options).
        truths: Index of the true option, shape (n,).
    """
    losses = []
    for temperature in TEMPERATURES:
        scaled = log_likelihoods / temperature
        scaled = scaled - scaled.max(axis=1, keepdims=True)
        log_sum = np.log(np.exp(scaled).sum(axis=1))
        losses.append(np.mean(log_sum - scaled[np.arange(len(truths)), truths]))
    return float(TEMPERATURES[int(np.argmin(losses))])


def fit_contact_threshold(
    contact_share: NDArray[np.floating], is_touched: NDArray[np.bool_]
) -> float:
    """Return the contact share below which nothing touches the gel.

    Midway between the untouched clips' upper and the touched clips' lower end where these are
    apart; otherwise the touched clips' lower end, so that contact is not missed.

    Args:
        contact_share: Mean contact mask of each clip, in [0, 1].
        is_touched: Whether the clip has contact.
    """
    lowest_touched = float(np.quantile(contact_share[is_touched], CONTACT_QUANTILE))
    if is_touched.all():
        return lowest_touched / 2
    highest_untouched = float(np.quantile(contact_share[~is_touched], 1 - CONTACT_QUANTILE))
    return (lowest_touched + min(highest_untouched, lowest_touched)) / 2
