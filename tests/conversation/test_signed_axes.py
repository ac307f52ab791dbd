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
        ("Is y increasing, or is it decreasing?", "Which way is it moving?"),
        ("Is it moving to lower columns or higher columns?", "Which way is it moving?"),
        ("Is it moving to lower or higher columns?", "Which way is it moving?"),
        (
            "Is it moving in the direction of increasing y or decreasing y?",
            "Which way is it moving?",
        ),
        ("Is it moving to higher columns or not?", "is it moving right or not?"),
        ("Does y go up?", "Which way is it moving?"),
        ("Does the row go down?", "Which way is it moving?"),
        ("Is the motion in +x?", "is the motion right?"),
        ("Is it in the +x direction?", "is it right?"),
        ("Does the motion vector point up?", "Is it moving up?"),
        ("Does the displacement vector point to the left?", "Is it moving left?"),
        ("Is there a slip vector?", "Does it slide?"),
        ("Which way does the motion vector point?", "Which way is it moving?"),
        ("Is the x and y displacement zero?", "It does not slide, right?"),
        ("Is dx zero?", "It does not slide along x, right?"),
        ("Is dy zero?", "It does not slide along y, right?"),
        ("Is theta positive?", "Is it turning clockwise?"),
        ("Is theta negative?", "Is it turning counterclockwise?"),
        ("What is the sign of theta?", "Which way is it moving?"),
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
        "Is the contact on the +x side?",
        "Is it on the +x side?",
        "Is it in positive x territory?",
        "Is it in positive x coordinates of the gel?",
        "What is theta?",
        "What is the motion vector?",
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
