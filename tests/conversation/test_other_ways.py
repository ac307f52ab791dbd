"""Ways to move that are none of those told are declined; turns and slides are not."""

import pytest

from geotlm_lm.conversation.other_ways import OTHER_WAYS, PARTIAL_SLIP, told_of_other_ways


@pytest.mark.parametrize(
    "text",
    ["did it roll?", "is the can rolling over?", "has it tipped?", "did the cap flip over?"],
)
def test_rolling_and_the_like_is_not_told(text):
    assert told_of_other_ways(text) == OTHER_WAYS


@pytest.mark.parametrize("text", ["is there incipient slip?", "any micro-slip?"])
def test_slip_in_part_is_not_told(text):
    assert told_of_other_ways(text) == PARTIAL_SLIP


@pytest.mark.parametrize(
    "text",
    ["is it turning?", "did it slip?", "did it roll to the left?", "is it flipped?", "any slip?"],
)
def test_what_is_told_is_left_alone(text):
    assert told_of_other_ways(text) is None
