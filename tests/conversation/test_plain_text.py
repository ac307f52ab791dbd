"""What every rule on words reads."""

import pytest

from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.plain_text import plain_text


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("Isn\u2019t it  MOVING?", "isn't it moving?"),
        (" Which\tway\n\ndoes it go? ", "which way does it go?"),
        ("", ""),
    ],
)
def test_case_apostrophes_and_spaces_are_told_apart_by_no_rule(text, plain):
    assert plain_text(text) == plain


def test_a_typeset_apostrophe_is_read_like_a_typed_one():
    typed, typeset = ("Doesn't it turn clockwise?", "Doesn\u2019t it turn clockwise?")
    assert claimed_motion(typed) == claimed_motion(typeset)
