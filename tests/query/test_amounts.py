"""How far it went: what is told of a bell, and the span it lies in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.core.figures import figure_of, rounded_up
from geotlm_lm.core.tolerance import TOLERANCES, within_tolerance
from geotlm_lm.core.twist import Component
from geotlm_lm.query.program import WAY_ATOMS
from geotlm_lm.query.values import BASES, Measure

amounts = st.builds(
    Measure,
    st.sampled_from(sorted(WAY_ATOMS)),
    st.floats(-60, 60),
    st.floats(0.001, 9),
    st.just("unit"),
    st.floats(0.01, 100),
)


@given(amounts)
def test_any_bell_gives_a_value_inside_its_span(told):
    low, high = told.span
    assert low <= told.value <= high
    assert 0 < told.probability <= 1


@pytest.mark.parametrize(("mean", "text"), [
    (0.04, "0.04"), (12.4, "12"), (99.4, "99"), (99.7, "100"), (154.6, "155"), (-160.2, "-160"),
    (1234.0, "1230"),
])  # fmt: skip
def test_every_sentence_rounds_an_amount_alike(mean, text):
    deviation = 0.05 * abs(mean)
    amount = Measure("turn", mean, deviation, "deg", TOLERANCES["deg"], is_signed=True)
    assert amount.figure == text
    assert figure_of(mean) == text
    low, high = amount.span
    assert low <= mean - 1.6 * deviation
    assert high >= mean + 1.6 * deviation
    assert rounded_up(high) == high


@pytest.mark.parametrize("mean", [0.3, 1.5, 5, 11, 25, 60])
@pytest.mark.parametrize("deviation", [0.05, 1.0, 4.0])
def test_the_probability_is_the_share_of_true_amounts_it_is_right_of(mean, deviation):
    told = Measure("turn", mean, deviation, "deg", TOLERANCES[BASES[Component.TURN]])
    true = np.random.default_rng(0).normal(mean, deviation, 20_000)
    right = np.mean([within_tolerance(told.value, one, "deg") for one in true])
    assert told.probability == pytest.approx(right, abs=0.015)
    low, high = told.span
    assert np.mean((true >= low) & (true <= high)) + np.mean(true < 0) >= 0.9 - 0.015
