"""Which way a half goes: the law of a turn."""

import pytest

from geotlm_lm.conversation.half_directions import direction_of_half
from geotlm_lm.core.labels import SLIDES, Motion, mirror, reverse, turn_by_quarter

CW, CCW, LEFT, RIGHT, UP, DOWN = (
    Motion.CLOCKWISE,
    Motion.COUNTERCLOCKWISE,
    Motion.LEFT,
    Motion.RIGHT,
    Motion.UP,
    Motion.DOWN,
)
HALVES = ("upper", "right", "lower", "left")


def test_a_clockwise_turn_carries_the_upper_half_to_the_right_and_so_on_round():
    assert [direction_of_half(half, CW) for half in HALVES] == [RIGHT, DOWN, LEFT, UP]


@pytest.mark.parametrize("half", HALVES)
def test_opposite_halves_and_opposite_turns_go_opposite_ways(half):
    across = HALVES[(HALVES.index(half) + 2) % 4]
    assert (
        direction_of_half(half, CW)
        == reverse(direction_of_half(half, CCW))
        == reverse(direction_of_half(across, CW))
    )


@pytest.mark.parametrize("half", HALVES)
def test_a_turn_of_the_image_turns_halves_and_ways_alike(half):
    turned = HALVES[HALVES.index(half) - 1]
    assert direction_of_half(turned, CW) == turn_by_quarter(direction_of_half(half, CW))
    if half in ("upper", "lower"):
        assert direction_of_half(half, mirror(CW)) == mirror(direction_of_half(half, CW))


@pytest.mark.parametrize("motion", SLIDES)
def test_all_halves_go_the_way_of_a_slide(motion):
    assert {direction_of_half(half, motion) for half in HALVES} == {motion}
