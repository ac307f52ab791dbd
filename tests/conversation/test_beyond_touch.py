"""What touch cannot tell, by the words for it; questions about motion never pass for that."""

import numpy as np
import pytest

from geotlm_lm.conversation.beyond_touch import asks_beyond_touch
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates

TYPES = load_templates().types


@pytest.mark.parametrize(
    "question",
    [
        "What colour is the lid?",
        "What am I touching?",
        "Did the knob click?",
        "Has the connector seated?",
        "Has the drawer opened?",
        "Is the peg inserted?",
        "Did it snap into place?",
        "What is the gripper holding?",
        "What's on the gel?",
        "Is there more than one contact?",
        "Is it hot, please?",
        "is the jar made of glass?",
        "Steel or brass?",
        "Is that glass?",
        "What size wrench do I need?",
        "Are there any scratches on the nut?",
        "and who made it?",
        "How does the cap look?",
        "What will it do tomorrow?",
        "whose bottle is that",
        "Is my key rusty or shiny?",
        "What is the weight of the cap?",
        "Any noise?",
        "Was the object picked up?",
        "Did we pick it up?",
        "material?",
        "Is there rust on it?",
        "Was it made in Spain?",
        "What is the contact made of?",
        "Is it a reverse thread?",
        "Does it have a left-hand thread?",
        "How many degrees celsius is it?",
        "Which way will it go tomorrow?",
        "Is there a risk of slip?",
        "any danger of losing it?",
        "Did the human turn it or the robot?",
        "was it the robot arm or a person?",
    ],
)
def test_words_for_what_no_touch_feels_are_known(question):
    assert asks_beyond_touch(question)


@pytest.mark.parametrize(
    "question",
    [
        "Is the glass turning?",
        "are you loosening the plug?",
        "Is it turning in the lock?",
        "Was that loosening the paper?",
        "Is it still touching my glass?",
        "Is the steel bolt turning clockwise?",
        "Which way does the white cap go?",
        "Is it moving slowly or quickly?",
        "What is the contact mass of the left half?",
        "What makes you think so?",
        "Which half moves which way?",
        "Did the gel move, or the object?",
        "How hard is it pressing?",
        "left or right?",
        "Is the cold bottle slipping?",
        "Has contact been made with the object?",
        "How many turns were made in this recording?",
        "Which motion was made by the cap?",
        "Is it slipping or just noise?",
        "Which way does the rusty bolt turn?",
        "Which way is the colour wheel turning?",
        "How far did the brand new cap slide?",
        "How many degrees did the scratched lid turn?",
        "Is the material slipping?",
        "Is it rotating about its center of mass?",
        "Which way does the weight slide?",
        "Does the stained cloth move left?",
        "Is the contact broken?",
        "Was contact broken?",
        "With a left-hand thread, is it turning clockwise?",
        "Did the person turn it clockwise?",
        "Is the gripper slipping or the object?",
        "Did the gel move or the robot?",
        "Did it turn and click?",
        "Did the drawer slide shut?",
        "Is it moving or stuck?",
        "Is it slipping on two contacts?",
        "What's in my hand doing?",
    ],
)
def test_motion_of_things_of_any_colour_or_material_is_not_beyond_touch(question):
    assert not asks_beyond_touch(question)


@pytest.mark.parametrize("type_id", sorted({*TYPES} - {"T17"}))
def test_no_question_that_touch_answers_passes_for_one_it_cannot(type_id):
    rng = np.random.default_rng(0)
    for motion in Motion:
        for wordings in ("seen", "held_out"):
            label = MotionLabel(motion)
            for asked in questions_for(label, rng, per_type=30, types=[type_id], wordings=wordings):
                assert not asks_beyond_touch(asked.question), asked.question


def test_most_questions_beyond_touch_are_known():
    rng = np.random.default_rng(0)
    asked = [
        asks_beyond_touch(one.question)
        for wordings in ("seen", "held_out")
        for one in questions_for(
            MotionLabel(Motion.LEFT), rng, per_type=300, types=["T17"], wordings=wordings
        )
    ]
    assert np.mean(asked[:300]) > 0.5
    assert np.mean(asked[300:]) > 0.95
