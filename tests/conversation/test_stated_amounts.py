"""Amounts that a question claims, and what holds of them."""

import pytest

from geotlm_lm.conversation.stated_amounts import StatedAmount, stated_amount, without_amount


@pytest.mark.parametrize(
    ("question", "stated"),
    [
        ("Did it turn 45 degrees?", StatedAmount(45.0, "deg", "about")),
        ("did it turn by about 4.5\N{DEGREE SIGN}?", StatedAmount(4.5, "deg", "about")),
        ("has it slid more than 3 mm to the right?", StatedAmount(3.0, "mm", "more")),
        ("did it move less than 12px?", StatedAmount(12.0, "px", "less")),
        ("more than 10 degrees?", StatedAmount(10.0, "deg", "more")),
        ("Did it move half a millimetre?", StatedAmount(0.5, "mm", "about")),
        ("Has it made a full revolution?", StatedAmount(360.0, "deg", "about")),
        ("did it turn a quarter turn", StatedAmount(90.0, "deg", "about")),
        ("did it go at least half a turn?", StatedAmount(180.0, "deg", "more")),
        ("How many degrees?", None),
        ("Which way, at 0.06 mm per pixel?", None),
        ("Did it turn no less than 5 degrees?", StatedAmount(5.0, "deg", "more")),
        ("Did it turn not more than 5 degrees?", StatedAmount(5.0, "deg", "less")),
        ("Did it turn 10 degrees over the whole clip?", StatedAmount(10.0, "deg", "about")),
        ("Did it slide 12 px within the recording?", StatedAmount(12.0, "px", "about")),
        ("did it turn 10 or 20 degrees?", None),
        ("did it turn 10 to 20 degrees?", None),
        ("Does it turn more than 30 deg/s?", None),
        ("Is it 20 degrees Celsius?", None),
        ("Is this a 10 mm nut?", None),
        ("Did it press 2 mm deep?", None),
        ("did it turn between 10 degrees and 20 degrees?", None),
        ("is it turning?", None),
        ("I turned it 45 degrees", None),
    ],
)
def test_an_amount_is_read_where_a_question_claims_one(question, stated):
    assert stated_amount(question) == stated


@pytest.mark.parametrize(
    ("bound", "amount", "holds"),
    [
        ("about", 12.0, True),
        ("about", 12.1, False),
        ("more", 10.1, True),
        ("more", 9.9, False),
        ("less", 9.9, True),
        ("less", 10.1, False),
    ],
)
def test_a_claim_holds_within_its_bound(bound, amount, holds):
    assert StatedAmount(10.0, "deg", bound).holds(amount, tolerance=2.0) is holds


def test_what_is_left_of_a_question_claims_its_motion_alone():
    assert without_amount("Did it slide 3 mm right?").split() == ["did", "it", "slide", "right?"]
    assert "turn" not in without_amount("Was it half a turn?")
