"""A state and its opposite in one question claim neither."""

import numpy as np
import pytest

from geotlm_lm.conversation.either_or import asked_whether_over, without_opposites
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    "question",
    [
        "Is it moving or stationary?",
        "moving or still?",
        "Is the cable static or dynamic",
        "is it in motion, or is it at rest?",
        "Is it still or moving?",
        "Does it move horizontally or vertically?",
        "Is it moving along the x axis or the y axis?",
        "is it moving in +x or -x?",
        "in the positive y direction or the negative y direction?",
        "Is dx positive or negative?",
        "is the y shift negative or positive?",
    ],
)
def test_moving_or_at_rest_asks_how_it_moves(question):
    assert without_opposites(question) == "Which way is it moving?"


@pytest.mark.parametrize("question", ["Touching or not touching?", "contact or no contact"])
def test_touching_or_not_asks_for_contact(question):
    assert without_opposites(question) == "Is anything touching the gel?"


@pytest.mark.parametrize(
    "question",
    [
        "Is it moving left or right?",
        "Is it moving left or still?",
        "Is it moving?",
        "Is it still?",
        "A) moving or still B) pressing",
        "Sliding or turning?",
        "Is it turning or is it still?",
        "Is the sensor moving or stationary?",
        "How sure are you that it is moving or still?",
        "Played backwards, is it moving or still?",
        "Is it touching, or not touching, and which way does it go?",
        "Which clip is moving or still?",
        "Is it moving or still touching?",
        "Is dx positive?",
        "Is it positive or negative?",
        "Is it moving along the x axis?",
    ],
)
def test_other_questions_stay_as_they_are(question):
    assert without_opposites(question) == question


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_otherwise(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert without_opposites(asked.question) == asked.question


@pytest.mark.parametrize(
    ("question", "going"),
    [
        ("Is it still moving or did it stop?", "Is it moving?"),
        ("so is the cap still turning, or has it stopped?", "Is it turning?"),
        ("Did it stop or is it still sliding?", "Is it sliding?"),
        ("still moving or already over", "Is it moving?"),
        ("Has it come to rest or is it in motion?", "Is it in motion?"),
    ],
)
def test_still_going_or_over_asks_whether_it_goes(question, going):
    assert asked_whether_over(question) == going


@pytest.mark.parametrize(
    "question",
    ["Is it moving or still?", "Is it still moving?", "Did it stop?", "Is it moving or turning?"],
)
def test_other_questions_ask_nothing_of_the_end(question):
    assert asked_whether_over(question) is None


@pytest.mark.parametrize(
    "question",
    [
        "approach or retreat?",
        "Is it approaching or receding?",
        "Did the contact begin or end?",
        "make or break?",
        "Is contact being made or broken?",
    ],
)
def test_contact_made_or_broken_asks_how_it_moves(question):
    assert without_opposites(question) == "Which way is it moving?"


@pytest.mark.parametrize(
    "question",
    [
        "Is it sliding or rotating or both?",
        "Rotation, slide or both?",
        "turning, slipping, or both",
    ],
)
def test_one_kind_or_both_asks_which_kind(question):
    assert without_opposites(question) == "Is it sliding or turning?"
