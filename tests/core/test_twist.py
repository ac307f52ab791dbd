"""When a component counts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.core.twist import (
    COMPONENTS,
    COUNTING_MM,
    COUNTING_PX,
    STILL_MM,
    STILL_PX,
    Component,
    counts,
)

BANDS = {
    Component.TURN: (STILL_PX, COUNTING_PX),
    Component.SLIDE: (STILL_PX, COUNTING_PX),
    Component.PRESS: (STILL_MM, COUNTING_MM),
}


@pytest.mark.parametrize("component", COMPONENTS)
@given(path=st.floats(0, 5))
def test_what_moves_little_does_not_count_what_moves_much_does_and_between_it_is_open(
    component, path
):
    low, high = BANDS[component]
    expected = False if path <= low else True if path >= high else None
    assert counts(component, path) is expected
