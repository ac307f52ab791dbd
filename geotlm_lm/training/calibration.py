"""Fit the numbers that decide how sure an answer is, on what no weight has seen; and judge them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits

from geotlm_lm.query.reader import Reader
from geotlm_lm.training.labelled import Labelled

TEMPERATURES = np.geomspace(0.25, 8.0, 161)
CONTACT_QUANTILE = 0.005
"""Share of touched clips that may fall below the contact threshold."""

BINS = 15
"""Equal-width bins, as in Guo et al. 2017 (On Calibration of Modern Neural Networks)."""


def fit_temperature(log_likelihoods: NDArray[np.floating], truths: NDArray[np.integer]) -> float:
    """Return the temperature under which the true of n options each are most likely."""
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

    Shares are the mean contact mask of each clip, in [0, 1].
    """
    lowest_touched = float(np.quantile(contact_share[is_touched], CONTACT_QUANTILE))
    if is_touched.all():
        return lowest_touched / 2
    highest_untouched = float(np.quantile(contact_share[~is_touched], 1 - CONTACT_QUANTILE))
    return (lowest_touched + min(highest_untouched, lowest_touched)) / 2


def expected_calibration_error(
    confidence: NDArray[np.floating], is_right: NDArray[np.bool_]
) -> float:
    """Return the mean gap between confidence and accuracy, bins weighted by their answers.

    Stated probabilities are in [0, 1], (n,), n >= 1, as is whether each answer was right.
    """
    confidence, is_right = np.asarray(confidence, float), np.asarray(is_right, float)
    if confidence.shape != is_right.shape or not confidence.size:
        raise ValueError(f"shapes differ or are empty: {confidence.shape}, {is_right.shape}")
    places = np.minimum((confidence * BINS).astype(int), BINS - 1)
    gaps = np.bincount(places, weights=confidence - is_right, minlength=BINS)
    return float(np.abs(gaps).sum() / confidence.size)


def calibrated_reader(reader: Reader, questions: Sequence[Labelled]) -> Reader:
    """Return a reader whose probabilities come true on questions that it was not trained on.

    The log-odds of what it tells are scaled and shifted to the greatest likelihood of whether its
    readings were the right ones (Platt 1999).
    """
    raw = Reader(reader.decoder, reader.spelling, (1.0, 0.0))
    odds, right = [], []
    for question in questions:
        reading = raw.read(question.text)
        odds.append(math.log(reading.probability / (1 - reading.probability)))
        right.append(question.is_met(reading.line))
    x, y = torch.tensor(odds), torch.tensor(right, dtype=torch.float32)
    line = torch.tensor([1.0, 0.0], requires_grad=True)
    optimiser = torch.optim.LBFGS([line], max_iter=100, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        optimiser.zero_grad()
        value = binary_cross_entropy_with_logits(line[0] * x + line[1], y)
        value.backward()
        return value

    optimiser.step(loss)
    slope, offset = map(float, line.detach())
    return Reader(reader.decoder, reader.spelling, (slope, offset))


SHARES = (1.0, 0.8, 0.6, 0.4)
"""Of weights that went on learning, in their mean with those before them."""


def best_share(
    reader_of: Callable[[float], Reader], questions: Sequence[Labelled]
) -> tuple[float, dict[float, float]]:
    """Return which mean of two readers' weights reads most questions exactly, and what each reads.

    What was learned last is read best by the last weights, and what was learned before by the
    former: a mean of both reads more than either (Wortsman et al. 2022, robust fine-tuning).

    Args:
        reader_of: Returns the reader of a share of the later weights.
        questions: None that either learned from.
    """
    read = {}
    for share in SHARES:
        reader = reader_of(share)
        met = [question.is_met(reader.read(question.text).line) for question in questions]
        read[share] = float(np.mean(met))
    return max(SHARES, key=read.__getitem__), read
