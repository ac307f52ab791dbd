"""Threads that go in or out, open or close are asked as tighter or looser."""

import numpy as np
import pytest

from geotlm_lm.conversation.thread_words import of_a_thread
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for

ASKED = "Is it tightening or loosening?"


@pytest.mark.parametrize(
    "question",
    [
        "Is the jar being opened?",
        "Is the bolt going in?",
        "Is the screw coming out?",
        "is it being opened?",
        "Is the bolt fastened or unfastened?",
        "Is the cap coming off?",
        "Is the tap being turned off?",
        "Am I opening the bottle?",
        "so is the nut going on or off?",
        "Does the lid open or close?",
    ],
)
@pytest.mark.parametrize("is_known", [False, True])
def test_what_has_a_thread_is_tightened_or_loosened(question, is_known):
    assert of_a_thread(question, is_known) == ASKED


@pytest.mark.parametrize(
    "question",
    ["in or out?", "is it closing?", "Will it advance or retract?", "and is it going in?"],
)
def test_once_a_thread_is_known_the_rest_is_of_it(question):
    assert of_a_thread(question, True) == ASKED
    assert of_a_thread(question, False) == question


@pytest.mark.parametrize(
    "question",
    [
        "Is the cap coming off the gel?",
        "Is the plug going in?",
        "Is the door being opened?",
        "Is the gripper closing?",
        "Is it going left?",
        "Is the screw moving?",
        "Is it pressing in?",
        "Is the knob being turned up?",
        "Should I open the gripper?",
        "Is the lid open to the left?",
    ],
)
@pytest.mark.parametrize("is_known", [False, True])
def test_other_questions_stay_as_they_are(question, is_known):
    assert of_a_thread(question, is_known) == question


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_otherwise(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=20):
            assert of_a_thread(asked.question, True) == asked.question


@pytest.mark.parametrize(
    "question",
    ["Is the jar closed?", "Is the bottle open?", "Is the cap fastened?", "Will the cap open?"],
)
def test_a_state_is_no_way_to_turn(question):
    assert of_a_thread(question, False) == question


@pytest.mark.parametrize(
    "question", ["Is the jar being closed?", "Is the bottle opening?", "Does the cap open?"]
)
def test_what_is_going_on_asks_which_way_the_thread_goes(question):
    assert of_a_thread(question, False) == ASKED
