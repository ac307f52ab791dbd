"""What is asked of a motion to come."""

import numpy as np
import pytest

from geotlm_lm.conversation.future import asks_what_comes
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    "question",
    [
        "Will it slip?",
        "Will the cap turn clockwise?",
        "will it keep moving",
        "Is it going to slip?",
        "Is the nut going to turn left?",
        "Which way will it turn?",
        "Where will the object go next?",
        "How fast will it spin?",
        "Which way will the sensor turn?",
        "Can the gripper turn?",
        "Would it slip?",
        "Would it turn if I pushed it?",
        "How long until contact is lost?",
        "Can it slip?",
        "How long until it has turned 90 degrees?",
        "time to turn by 90 degrees?",
        "Will it be sliding down soon?",
    ],
)
def test_a_motion_to_come_is_known_by_its_words(question):
    assert asks_what_comes(question)


@pytest.mark.parametrize(
    "question",
    [
        "Is it slipping?",
        "Is it going to the left?",
        "Is it going up?",
        "Could it be turning?",
        "Would it be spinning?",
        "Will this turn tighten the nut?",
        "Will this motion loosen it?",
        "If the image were mirrored, which way will it turn?",
        "Played backwards, which way will it turn?",
        "Which way will it turn in the mirror?",
        "Is it likely to turn clockwise?",
        "Is it likely to slip?",
        "Could it turn clockwise?",
        "How long before it turned?",
        "How long till contact was lost?",
        "How long will it take at this speed to turn 360 degrees?",
        "Is it likely that it turns clockwise?",
        "Can you tell which way it turns?",
        "How long did it take to turn?",
        "Will you tell me which way it turns?",
    ],
)
def test_a_motion_seen_supposed_or_of_something_else_is_none_to_come(question):
    assert not asks_what_comes(question)


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_template_that_touch_answers_asks_what_comes(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        for asked in questions_for(MotionLabel(motion), rng, wordings=wordings, per_type=20):
            assert asked.type_id == "T17" or not asks_what_comes(asked.question), asked.question
