"""What holds of an amount or a range that a question claims."""

from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.conversation.stated_amounts import StatedAmount, StatedRange

drawn = settings(derandomize=True, deadline=None, database=None)

amounts = st.floats(0.1, 300.0)
tolerances = st.floats(0.0, 20.0)


@given(amounts, amounts)
@drawn
def test_more_and_less_than_an_amount_exclude_each_other(claimed, measured):
    more, less = (StatedAmount(claimed, "deg", bound) for bound in ("more", "less"))
    assert more.holds(measured, 0.0) == (measured > claimed)
    assert more.holds(measured, 0.0) != less.holds(measured, 0.0)


@given(amounts, amounts, tolerances)
@drawn
def test_about_an_amount_is_within_its_tolerance_on_either_side(claimed, measured, tolerance):
    about = StatedAmount(claimed, "px", "about")
    assert about.holds(measured, tolerance) == (abs(measured - claimed) <= tolerance)
    assert about.holds(claimed, tolerance)


@given(amounts, amounts, amounts, tolerances, tolerances)
@drawn
def test_a_range_reaches_as_far_beyond_its_ends_as_each_tolerates(one, other, measured, low, high):
    stated = StatedRange(min(one, other), max(one, other), "mm")
    within = stated.low - low <= measured <= stated.high + high
    assert stated.holds(measured, low, high) == within
    assert stated.ends == (stated.low, stated.high)


@given(amounts, tolerances)
@drawn
def test_a_range_of_one_amount_is_about_that_amount(claimed, tolerance):
    stated, about = (
        StatedRange(claimed, claimed, "deg"),
        StatedAmount(claimed, "deg", "about"),
    )
    for measured in (claimed - tolerance / 2, claimed, claimed + tolerance / 2):
        assert stated.holds(measured, tolerance, tolerance) == about.holds(measured, tolerance)
