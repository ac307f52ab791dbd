"""A sign of x or y is a way: y and the row numbers grow downwards."""

import numpy as np
import pytest

from geotlm_lm.conversation.signed_axes import asked_of_axes, counts_pixels
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("question", "asked"),
    [
        ("Does the row index decrease?", "Is it moving up?"),
        ("does the column index of the contact increase?", "Is it moving right?"),
        ("is the row number growing", "Is it moving down?"),
        ("Is delta y negative?", "Is it moving up?"),
        ("is the x component negative?", "Is it moving left?"),
        ("dx > 0?", "Is it moving right?"),
        ("Does x go up?", "Is it moving right?"),
        ("is it moving in the +y direction", "is it moving down"),
        ("Does the object slide along -x?", "does the object slide left?"),
        ("Is the bead going towards positive x?", "is the bead going right?"),
        ("Is it moving in the direction of increasing columns?", "is it moving right?"),
        ("towards smaller y?", "up?"),
        ("does the row index decrease in it?", "Is it moving up?"),
        ("What is the sign of delta y?", "Which way is it moving?"),
        ("Does the row index increase or decrease?", "Which way is it moving?"),
    ],
)
def test_a_sign_is_asked_as_a_way(question, asked):
    assert asked_of_axes(question) == asked


@pytest.mark.parametrize(
    "question",
    [
        "Is it moving along the x axis?",
        "is it moving in +x or -x?",
        "Is it moving in the positive direction?",
        "x?",
        "How far does x go?",
        "Does the speed increase?",
    ],
)
def test_other_questions_name_no_sign(question):
    assert asked_of_axes(question) is None


def test_rows_and_columns_are_those_of_the_recorded_image():
    assert counts_pixels("does the column number grow?")
    assert counts_pixels("sign of the row index?")
    assert not counts_pixels("is dx positive?")


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_names_one(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert asked_of_axes(asked.question) is None
