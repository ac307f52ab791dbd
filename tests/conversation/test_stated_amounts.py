"""Amounts that a question claims, and what holds of them."""

import numpy as np
import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.stated_amounts import (
    StatedAmount,
    StatedRange,
    claimed_amount,
    claims_unread_amount,
    denies_amount,
    stated_amount,
    stated_range,
    stated_speed,
    without_amount,
)
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


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
        ("move > 3 px?", StatedAmount(3.0, "px", "more")),
        (
            "rotated \N{GREATER-THAN OR EQUAL TO} 10\N{DEGREE SIGN}?",
            StatedAmount(10.0, "deg", "more"),
        ),
        ("slid < 2 mm?", StatedAmount(2.0, "mm", "less")),
        ("Did it slide on a 5 x 6 mm pad?", None),
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


@pytest.mark.parametrize(
    ("question", "stated"),
    [
        ("Did it turn ninety degrees?", StatedAmount(90.0, "deg", "about")),
        ("Did it slide 0.5 cm or more?", StatedAmount(5.0, "mm", "more")),
        ("did it turn > 10 degrees?", StatedAmount(10.0, "deg", "more")),
        ("It turned 45 degrees, right?", StatedAmount(45.0, "deg", "about")),
        ("Can you tell me if it turned 45 degrees?", StatedAmount(45.0, "deg", "about")),
        ("a hundred pixels?", StatedAmount(100.0, "px", "about")),
        ("Did the 10 mm nut turn 20 degrees?", StatedAmount(20.0, "deg", "about")),
        ("Did it turn 10 degrees or not?", StatedAmount(10.0, "deg", "about")),
        ("Did it do half a turn?", StatedAmount(180.0, "deg", "about")),
        ("It has done half a turn, right?", StatedAmount(180.0, "deg", "about")),
        ("Did the nut (10 mm) turn 20 degrees?", StatedAmount(20.0, "deg", "about")),
        ("Did the cap, 28 mm wide, turn 20 degrees?", StatedAmount(20.0, "deg", "about")),
        ("Did the bead of 2 mm slide 1 mm?", StatedAmount(1.0, "mm", "about")),
        ("Is it 10 mm wide?", None),
        ("Did the 10 mm nut turn?", None),
    ],
)
def test_an_amount_is_read_however_it_is_written(question, stated):
    assert stated_amount(question) == stated


@pytest.mark.parametrize(
    ("question", "stated"),
    [
        ("Did it turn between 50 and 80 degrees?", StatedRange(50.0, 80.0, "deg")),
        ("Did it slide from 5 to 10 px?", StatedRange(5.0, 10.0, "px")),
        ("5-10 mm?", StatedRange(5.0, 10.0, "mm")),
        ("Did it turn more than 10 but less than 20 degrees?", StatedRange(10.0, 20.0, "deg")),
        ("Did it go over 10 px and under 20 px?", StatedRange(10.0, 20.0, "px")),
        ("Is it turning at 10 to 20 deg/s?", StatedRange(10.0, 20.0, "deg/s")),
        ("Did it turn 20 degrees?", None),
    ],
)
def test_a_range_is_read_where_a_question_claims_one(question, stated):
    assert stated_range(question) == stated


@pytest.mark.parametrize(
    ("question", "stated"),
    [
        ("faster than 100 degrees per second?", StatedAmount(100.0, "deg/s", "more")),
        ("at 5 rpm?", StatedAmount(30.0, "deg/s", "about")),
        ("Is it slower than 10 px/s?", StatedAmount(10.0, "px/s", "less")),
        ("Does it slide at 2 mm per second?", StatedAmount(2.0, "mm/s", "about")),
        ("Is its speed 30 degrees per second?", StatedAmount(30.0, "deg/s", "about")),
        ("Is it slower than 1 turn per minute?", StatedAmount(6.0, "deg/s", "less")),
        ("faster than one revolution per minute?", StatedAmount(6.0, "deg/s", "more")),
        ("faster than a rotation a second?", StatedAmount(360.0, "deg/s", "more")),
        ("faster than 10 px?", None),
        ("Did it turn 10 degrees?", None),
    ],
)
def test_a_speed_is_read_where_a_question_claims_one(question, stated):
    assert stated_speed(question) == stated


@pytest.mark.parametrize(
    ("amount", "holds"), [(7.9, False), (8.1, True), (15.0, True), (23.9, True), (24.1, False)]
)
def test_a_range_holds_within_its_ends_and_their_tolerances(amount, holds):
    assert StatedRange(10.0, 20.0, "deg").holds(amount, 2.0, 4.0) is holds


@pytest.mark.parametrize(
    "question",
    [
        "Did it turn a few degrees?",
        "did it turn 10 or 20 degrees?",
        "did it turn 45?",
        "Did it turn 5 degrees per frame?",
        "Did it turn -20 degrees?",
        "Did it slide 5 mm in 2 seconds?",
        "Did it turn by pi radians?",
        "Did it press 2 mm deep?",
        "Is this a 10 mm nut?",
        "faster than 10 px?",
        "Does it rotate through 30?",
        "Did it turn around 90?",
        "more than 10?",
        "Did it slide 5 mm within 2 seconds?",
        "It did not turn 20 degrees clockwise, right?",
        "Is it 28 mm wide?",
    ],
)
def test_a_number_that_cannot_be_judged_is_known_as_claimed(question):
    assert claimed_amount(question) is None
    assert claims_unread_amount(question)


@pytest.mark.parametrize(
    "question",
    [
        "Did it turn 45 degrees?",
        "How many degrees?",
        "Is it 20 degrees Celsius?",
        "Did the 10 mm nut turn?",
        "Did bolt 3 turn?",
        "Which of the two turned more than 10 degrees?",
        "I turned it 45 degrees",
        "A) left B) right 2) up",
        "Does the cap, 28 mm wide, turn clockwise?",
        "Is the cap 28 mm in diameter turning?",
        "Is the nut (13 mm) turning clockwise?",
        "Do 28 mm caps turn clockwise?",
        "Is the bolt of 10 mm moving?",
        "Does the cap with a diameter of 28 mm turn?",
        "Did it turn within 2 seconds?",
        "Does it turn in 4 frames?",
        "Is there more than one?",
        "Is the scale 0.06 mm per pixel?",
        "Is it one rotation or a slide?",
    ],
)
def test_what_is_judged_or_claims_no_number_is_not_declined(question):
    assert not claims_unread_amount(question)


@pytest.mark.parametrize(
    ("question", "denies"),
    [
        ("It did not turn 90 degrees, right?", True),
        ("It never turned more than 90 degrees, right?", True),
        ("Is it true that it didn't turn 90 degrees?", True),
        ("Is it false that it turned 90 degrees?", True),
        ("Is it false that it did not turn 90 degrees?", False),
        ("It turned 90 degrees, didn't it?", False),
        ("Didn't it turn 90 degrees?", False),
        ("It is not more than 5 degrees, right?", False),
        ("It did not turn, right?", False),
    ],
)
def test_an_amount_is_denied_where_a_statement_says_that_it_is_not_so(question, denies):
    assert denies_amount(question) is denies


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_claims_an_amount(wordings):
    rng = np.random.default_rng(4)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            question = read_facts(asked.question, FrameSpec()).rest
            assert claimed_amount(question) is None, asked
            assert not claims_unread_amount(question), asked
