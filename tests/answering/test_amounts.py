"""How far it went: the amount most probably right, its span, and its sentence."""

import numpy as np
import pytest

from geotlm_lm.answering.amounts import Amount, amount_in, best_amount
from geotlm_lm.core.tolerance import TOLERANCES, within_tolerance
from geotlm_lm.odometry.odometer import amounts

DEGREES = [1, 2, 4, 6, 8, 10, 12, 15, 18, 22, 27, 33, 40, 48, 58, 70]


def weighed(weights, unit="deg"):
    """The amount told of these probabilities, by amount."""
    return best_amount(tuple(weights), np.array(list(weights.values())), unit, TOLERANCES[unit])


def bell(centre, spread, amounts=DEGREES):
    weights = np.exp(-0.5 * np.square((np.log(amounts) - np.log(centre)) / spread))
    return dict(zip(amounts, weights / weights.sum(), strict=True))


def test_what_is_sure_is_told():
    amount = weighed({one: float(one == 12) for one in DEGREES})
    assert amount.value in (12, 13)
    assert (amount.unit, amount.word) == ("deg", f"{amount.value:g} deg")
    assert amount.probability == pytest.approx(1.0)
    # All that is nearer to 12 than to 10 and 15.
    assert (amount.low, amount.high) == (11, 14)


def test_between_two_options_as_likely_lies_what_is_right_of_both():
    # 12 is right from 10 to 15, but 14 from 11.7 to 17.5: of what 12 and 15 stand for, 11 to 16.5.
    amount = weighed({one: 0.5 * (one in (12, 15)) for one in DEGREES})
    assert amount.value not in DEGREES
    assert 12 < amount.value < 15
    assert (amount.low, amount.high) == (11, 17)


def test_a_likely_amount_apart_from_the_others_is_not_told():
    """One option of 0.3 beside seven of 0.1 that are near one another: right is who tells those."""
    crowd = dict.fromkeys([12, 15, 18, 22], 0.175)
    assert weighed({one: 0.3 if one == 2 else crowd.get(one, 0.0) for one in DEGREES}).value > 12


@pytest.mark.parametrize("centre", [1.5, 5, 11, 25, 60])
@pytest.mark.parametrize("spread", [0.05, 0.2, 0.5])
def test_the_probability_is_the_share_of_true_amounts_it_is_right_of(centre, spread):
    weights, rng = bell(centre, spread), np.random.default_rng(0)
    amount = weighed(weights)
    middles = [0.5 * (a + b) for a, b in zip(DEGREES[:-1], DEGREES[1:], strict=True)]
    edges = [0.5, *middles, 76.0]
    cells = rng.choice(len(DEGREES), 20_000, p=list(weights.values()))
    true = rng.uniform(np.array(edges)[cells], np.array(edges)[cells + 1])
    right = np.mean([within_tolerance(amount.value, one, "deg") for one in true])
    assert amount.probability == pytest.approx(right, abs=0.015)
    inside = np.mean((true >= amount.low) & (true <= amount.high))
    assert inside >= 0.9 - 0.015


def test_it_is_more_often_right_than_the_likeliest_option():
    rng, right = np.random.default_rng(1), {"told": [], "likeliest": []}
    for _ in range(300):
        true = float(np.exp(rng.uniform(np.log(3), np.log(50))))
        felt = bell(true * np.exp(rng.normal(0, 0.2)), 0.2)
        rough = {one: share * rng.uniform(0.3, 1.7) for one, share in felt.items()}
        right["told"].append(within_tolerance(weighed(rough).value, true, "deg"))
        right["likeliest"].append(within_tolerance(max(rough, key=rough.get), true, "deg"))
    assert np.mean(right["told"]) > np.mean(right["likeliest"]) + 0.03


@pytest.mark.parametrize(
    ("unit", "read", "scale"), [("deg", "deg", 1), ("px", "px", 2), ("mm", "px", 0.01)]
)
def test_any_probabilities_give_an_amount_inside_its_span(unit, read, scale):
    rng, weighed_ones = np.random.default_rng(2), (amounts(read) * scale).tolist()
    for _ in range(100):
        weights = rng.random(len(weighed_ones)) ** rng.integers(1, 30)
        amount = weighed(dict(zip(weighed_ones, weights / weights.sum(), strict=True)), unit)
        assert 0 <= amount.low <= amount.value <= amount.high
        assert 0 < amount.probability <= 1
        assert amount_in(amount.word) == (amount.value, unit)


@pytest.mark.parametrize(
    ("amount", "text"),
    [
        (Amount(13, "deg", 10, 17, 0.8), "About 13 degrees of turning, likely 10 to 17."),
        (Amount(1, "deg", 1, 2, 0.8), "About 1 degree of turning, likely 1 to 2."),
        (Amount(14, "px", 12, 17, 0.8), "About 14 pixels of sliding, likely 12 to 17."),
        (Amount(1.0, "mm", 0.7, 1.3, 0.8), "About 1 millimetre of sliding, likely 0.7 to 1.3."),
        (
            Amount(12, "deg", 9, 15, 0.8).per_second(0.12),
            "About 100 degrees per second on average, likely 75 to 120.",
        ),
        (
            Amount(0.4, "mm", 0.1, 0.7, 0.8).per_second(3.0),
            "About 0.13 millimetres per second on average, likely 0.033 to 0.23.",
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
