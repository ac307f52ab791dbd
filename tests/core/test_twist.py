"""When a component moves."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.core.twist import (
    AT_REST_MM,
    AT_REST_PX,
    COMPONENTS,
    MOVING_MM,
    MOVING_PX,
    Component,
    moves,
)

BANDS = {
    Component.TURN: (AT_REST_PX, MOVING_PX),
    Component.SLIDE: (AT_REST_PX, MOVING_PX),
    Component.PRESS: (AT_REST_MM, MOVING_MM),
}


@pytest.mark.parametrize("component", COMPONENTS)
@given(path=st.floats(0, 5))
def test_what_is_at_rest_does_not_move_and_what_hardly_does_is_not_graded(component, path):
    low, high = BANDS[component]
    expected = False if path <= low else True if path >= high else None
    assert moves(component, path) is expected
