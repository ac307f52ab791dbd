"""Parts of a picture by their names."""

import pytest

from geotlm_lm.conversation.contact_location import place_in_picture


@pytest.mark.parametrize(
    ("across", "down", "part"),
    [
        (0.5, 0.5, "middle"),
        (0.6, 0.4, "middle"),
        (0.1, 0.5, "left middle"),
        (0.5, 0.9, "lower middle"),
        (0.9, 0.1, "upper right"),
        (0.0, 1.0, "lower left"),
    ],
)
def test_a_point_is_named_by_the_third_it_lies_in(across, down, part):
    assert place_in_picture(across, down) == part
