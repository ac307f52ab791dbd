"""How far it went: what is told of a bell, its span, and its sentence."""

import numpy as np
import pytest

from geotlm_lm.answering.amounts import Amount, Measure, amount_in
from geotlm_lm.core.tolerance import TOLERANCES, within_tolerance


def measure(mean, deviation, unit="deg"):
    return Measure(mean, deviation, unit, TOLERANCES[unit], "")


@pytest.mark.parametrize("mean", [0.3, 1.5, 5, 11, 25, 60])
@pytest.mark.parametrize("deviation", [0.05, 1.0, 4.0])
def test_the_probability_is_the_share_of_true_amounts_it_is_right_of(mean, deviation):
    told = measure(mean, deviation).amount()
    true = np.random.default_rng(0).normal(mean, deviation, 20_000)
    right = np.mean([within_tolerance(told.value, one, "deg") for one in true])
    assert told.probability == pytest.approx(right, abs=0.015)
    inside = np.mean((true >= told.low) & (true <= told.high))
    assert inside + np.mean(true < 0) >= 0.9 - 0.015


@pytest.mark.parametrize("unit", ["deg", "px", "mm"])
def test_any_bell_gives_an_amount_inside_its_span(unit):
    rng = np.random.default_rng(2)
    for _ in range(200):
        told = measure(rng.exponential(10), rng.exponential(3), unit).amount()
        assert 0 <= told.low <= told.value <= told.high
        assert 0 < told.probability <= 1
        assert amount_in(told.word) == (told.value, unit)


@pytest.mark.parametrize(
    ("amount", "text"),
    [
        (Amount(13, "deg", 10, 17, 0.8), "About 13 degrees of turning, likely 10 to 17."),
        (Amount(1, "deg", 1, 2, 0.8), "About 1 degree of turning, likely 1 to 2."),
        (Amount(14, "px", 12, 17, 0.8), "About 14 pixels of sliding, likely 12 to 17."),
        (
            Amount(0.3, "mm", 0.1, 0.5, 0.8, "pressing in"),
            "About 0.3 millimetres of pressing in, likely 0.1 to 0.5.",
        ),
        (
            Amount(12, "deg", 9, 15, 0.8).per_second(0.12),
            "About 100 degrees per second on average, likely 75 to 120.",
        ),
        (
            Amount(70, "deg", 60, 76, 0.8).per_second(3e-5),
            "About 2300000 degrees per second on average, likely 2000000 to 2500000.",
        ),
    ],
)
def test_an_amount_in_words(amount, text):
    assert amount.sentence() == text


@pytest.mark.parametrize("word", [None, "", "yes", "12", "12 in", "deg", "12 deg/s"])
def test_what_is_no_amount_is_none(word):
    assert amount_in(word) is None
