"""Who does not know something and asks for it asks that."""

import numpy as np
import pytest

from geotlm_lm.conversation.indirect import asked_within, claim_within
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
        ("could you tell me if it is slipping or not", "Is it slipping or not?"),
        (
            "Could you please tell me whether the cap turns clockwise?",
            "Does the cap turn clockwise?",
        ),
        ("can you say whether the part slid", "Did the part slide?"),
        ("Hello, would you mind telling me if the bead is sliding?", "Is the bead sliding?"),
        ("I would like to know if it turns left.", "Does it turn left?"),
        ("do you know if it is rotating?", "Is it rotating?"),
        ("Any idea if there is contact?", "Is there contact?"),
        (
            "I was wondering whether you might be able to tell me which way the cap is turning?",
            "Which way the cap is turning?",
        ),
        ("Is it possible to tell whether my part moved?", "Did my part move?"),
        ("I need to know whether it spun to the left", "Did it spin to the left?"),
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


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("Tell me whether it is still.", "Is it still?"),
        ("Can you tell whether it goes left?", "Does it go left?"),
        ("check if the part slid", "Did the part slide?"),
        ("could you tell me if it slips", "Does it slip?"),
    ],
)
def test_a_claim_is_found_behind_what_models_know_too(text, asked):
    assert claim_within(text) == asked


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_otherwise(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=20):
            assert asked_within(asked.question) == asked.question


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("Can you tell whether or not it turns?", "Does it turn?"),
        ("Has it moved right?", "Did it move right?"),
        ("has the nut gone up?", "Did the nut go up?"),
        ("Has it moved?", "Has it moved?"),
    ],
)
def test_whether_or_not_and_what_has_gone_a_way_are_asked_plainly(text, asked):
    assert asked_within(text) == asked
