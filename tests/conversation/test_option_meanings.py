"""Options that are true of several motions, or of all that the others leave."""

import numpy as np
import pytest

from geotlm_lm.conversation.option_meanings import (
    initials_spelt_out,
    offers_neither,
    option_sets,
    true_option,
)
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for

CCW, LEFT, UP, STILL, PRESS, NONE = (
    Motion.COUNTERCLOCKWISE,
    Motion.LEFT,
    Motion.UP,
    Motion.STILL,
    Motion.PRESS,
    Motion.NONE,
)


@pytest.mark.parametrize(
    ("question", "motion", "letter"),
    [
        ("Choose: (a) clockwise (b) counterclockwise (c) not rotating", CCW, "B"),
        ("Choose: (a) clockwise (b) counterclockwise (c) not rotating", LEFT, "C"),
        ("(A) clockwise (B) counterclockwise (C) no rotation", CCW, "B"),
        ("(A) cw (B) ccw (C) it doesn't turn", CCW, "B"),
        ("(A) cw (B) ccw (C) it does not rotate. Answer with the option's letter.", STILL, "C"),
        ("(A) cw (B) ccw (C) does not turn", UP, "C"),
        ("C: not rotating at all, A: cw, B: ccw", LEFT, "C"),
        ("A) left B) right C) neither", UP, "C"),
        ("A) left B) right C) none of these", LEFT, "A"),
        ("A) slips B) does not slip", STILL, "B"),
        ("A) slips B) does not slip", LEFT, "A"),
        ("1. it slides 2. it turns 3. something else", PRESS, "3"),
        ("A) moves B) still, not moving C) nothing touches", STILL, "B"),
        ("A) moves B) touching but not moving C) nothing touches", NONE, "C"),
        ("A) moves B) does not move C) no contact", NONE, "C"),
        ("A) turns B) left", UP, None),
        ("A) cw B) ccw C) left D) right E) none of these", PRESS, "E"),
        ("A) cw B) ccw C) left D) right E) none of these", LEFT, "C"),
    ],
)
def test_the_narrowest_option_that_is_true_is_chosen(question, motion, letter):
    assert true_option(option_sets(question), motion) == letter


def test_the_words_of_an_option_end_where_the_asking_goes_on():
    sets = option_sets("(A) cw (B) it does not rotate Answer with the option's letter")
    assert sets["B"][0] == "it does not rotate"


@pytest.mark.parametrize(
    "question",
    [
        "A) left B) right",
        "A) left B) no contact",
        "A) not touching B) clockwise C) still",
        "A) left B) jiggling C) does not slip",
        "Is it not rotating?",
        "A) does not slip",
        "",
    ],
)
def test_other_choices_are_left_to_the_model(question):
    assert option_sets(question) is None


@pytest.mark.parametrize(
    ("question", "offers"),
    [
        ("left, right or neither?", True),
        ("cw, ccw, or neither", True),
        ("up, down or none of these?", True),
        ("left or right?", False),
        ("left or neither?", False),
        ("rotation, slide, press, release or none?", False),
        ("Is it neither left nor right?", False),
    ],
)
def test_neither_is_offered_beside_two_directions(question, offers):
    assert offers_neither(question) is offers


@pytest.mark.parametrize(
    ("question", "words"),
    [
        ("L, R, U or D?", "left or right or up or down?"),
        ("L/R", "left or right?"),
        ("u or d?", "up or down?"),
        ("L", "L"),
        ("Did U see it?", "Did U see it?"),
        ("left or right?", "left or right?"),
    ],
)
def test_initials_alone_are_spelt_out(question, words):
    assert initials_spelt_out(question) == words


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_otherwise(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert option_sets(asked.question) is None, asked
            assert not offers_neither(asked.question), asked
            assert initials_spelt_out(asked.question) == asked.question


@pytest.mark.parametrize(
    "question",
    [
        "clockwise / counterclockwise / not rotating",
        "left or right, no motion?",
        "up, down or none",
    ],
)
def test_what_is_none_of_them_may_be_said_so(question):
    assert offers_neither(question)


def test_initials_after_a_command_are_spelt_out():
    assert initials_spelt_out("return L, R, U or D") == "left or right or up or down?"


def test_otherwise_is_all_the_rest():
    sets = option_sets("If it goes up say A, otherwise B.")
    assert true_option(sets, Motion.UP) == "A"
    assert true_option(sets, Motion.CLOCKWISE) == "B"
