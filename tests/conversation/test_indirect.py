"""Who does not know something and asks for it asks that."""

import numpy as np
import pytest

from geotlm_lm.conversation.indirect import asked_within
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        (
            "I can't tell whether it is going left or right, can you?",
            "Is it going left or right?",
        ),
        (
            "I can't tell if it's turning clockwise or counterclockwise, can you?",
            "Is it turning clockwise or counterclockwise?",
        ),
        ("I'm not sure whether the cap was still. Can you tell me?", "Was the cap still?"),
        ("we don't know if it is sliding", "Is it sliding?"),
        ("I wonder which way it turns", "Which way it turns?"),
        ("I cannot see what direction it goes; do you know?", "What direction it goes?"),
    ],
)
def test_the_question_inside_is_asked(text, asked):
    assert asked_within(text) == asked


@pytest.mark.parametrize(
    "text",
    [
        "Can you tell whether it goes left?",
        "I can't tell, which way does it go?",
        "Is it going left or right, can you tell?",
        "I don't know the thread.",
        "I don't know if you are right.",
        "Tell me whether it is still.",
        "I can see whether it is still, so why ask?",
    ],
)
def test_other_texts_stay_as_they_are(text):
    assert asked_within(text) == text


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_otherwise(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=20):
            assert asked_within(asked.question) == asked.question
