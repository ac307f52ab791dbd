"""When a component counts, and what mirrors and time do to a motion."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.core.labels import mirror, reverse
from geotlm_lm.core.twist import (
    COMPONENTS,
    COUNTING_MM,
    COUNTING_PX,
    STILL_MM,
    STILL_PX,
    Component,
    Twist,
    counts,
)

numbers = st.floats(-60, 60).filter(lambda value: abs(value) > 1e-6)
twists = st.builds(Twist, numbers, numbers, numbers, numbers)

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


@given(twist=twists, radius=st.floats(0, 100))
def test_a_mirror_and_the_clip_backwards_change_which_way_and_not_how_far(twist, radius):
    for component in COMPONENTS:
        for other, change in ((twist.mirrored(), mirror), (twist.reversed(), reverse)):
            assert other.path(component, radius) == pytest.approx(twist.path(component, radius))
            if abs(abs(twist.right_px) - abs(twist.down_px)) > 1e-6:  # else two ways are as near
                assert other.way(component) == change(twist.way(component))
