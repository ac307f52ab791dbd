"""Sizes of things, which are no amounts that anything moved by."""

import pytest

from geotlm_lm.conversation.thing_sizes import without_sizes


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("does the cap, 28 mm wide, turn?", "does the cap turn?"),
        ("does a screw 10 mm long turn?", "does a screw turn?"),
        ("is the bolt, which is 10 mm long, moving?", "is the bolt moving?"),
        ("is the cap 28 mm in diameter turning?", "is the cap turning?"),
        ("is the nut (13 mm) turning?", "is the nut turning?"),
        ("is the cap (28 mm wide) turning?", "is the cap turning?"),
        ("is the bolt of 10 mm at rest?", "is the bolt at rest?"),
        ("do 28 mm caps turn?", "do caps turn?"),
        ("is the bolt of 10 mm moving?", "is the bolt moving?"),
        ("does the cap with a diameter of 28 mm turn?", "does the cap turn?"),
    ],
)
def test_the_size_of_a_thing_is_taken_out(text, rest):
    assert without_sizes(text) == rest


@pytest.mark.parametrize(
    "text",
    [
        "is it 10 mm wide?",
        "is the cap 28 mm wide?",
        "is the cap 28 mm wide and round?",
        "did it press 2 mm deep?",
        "did it slide 5 mm?",
        "was the slide (5 mm) to the right?",
        "was there a slide of 5 mm to the right?",
        "did it move a distance of 3 mm to the left?",
        "did it turn (90 degrees) right?",
        "did the bead move 3 mm?",
    ],
)
def test_an_amount_that_is_claimed_stays(text):
    assert without_sizes(text) == text
