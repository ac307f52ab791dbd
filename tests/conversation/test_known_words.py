"""What a model takes for another question is asked in words that it knows."""

import numpy as np
import pytest

from geotlm_lm.conversation.known_words import in_known_words, names_slip
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    "question",
    [
        "Has the object slipped out of the gripper?",
        "Has the object left the sensor?",
        "Did the object leave the sensor?",
        "Did I lose the object?",
        "did we drop it?",
        "Did I miss the object?",
        "Is it free of contact?",
        "Is the sensor idle?",
        "contact lost?",
        "Is the gripper empty?",
        "Is the grasp empty?",
        "Is the hand now empty?",
        "Is the object gone?",
        "Is the gel clear?",
        "Has my key fallen off the finger?",
        "Did it fall?",
        "Has the nut dropped out?",
        "Did contact break?",
        "Is the object escaping?",
        "Has the contact ended?",
    ],
)
def test_what_is_lost_touches_no_more(question):
    assert in_known_words(question) == "Has contact been lost?"


@pytest.mark.parametrize(
    "question",
    [
        "Do I hold something?",
        "Am I holding the cap?",
        "Have we got it?",
        "Is the robot gripping my bolt?",
        "Is it held?",
        "Is it pressed?",
        "Is the coin pressed against the gel?",
        "Do you feel something?",
        "Has contact been made?",
        "Have we made contact?",
        "object detected?",
        "Is contact present?",
        "There is contact, right?",
        "Is there still contact?",
        "Isn't it touching?",
        "Aren't you touching anything?",
        "Did contact start?",
        "Feel anything?",
        "Got it?",
        "Did I grab the nut?",
        "Is it in my hand?",
        "Is the object present?",
        "Is something pressing against the gel?",
    ],
)
def test_what_is_held_or_pressed_touches(question):
    assert in_known_words(question) == "Is anything touching the gel?"


@pytest.mark.parametrize(
    "question",
    ["Is the object being pressed against the sensor?", "is it being pushed on the gel"],
)
def test_what_is_being_pressed_against_the_gel_is_asked_both(question):
    assert in_known_words(question) == "Is anything touching the gel? Is it pressing in?"


@pytest.mark.parametrize(
    "question",
    [
        "Is the grasp stable?",
        "stable?",
        "Is it steady?",
        "Has it settled?",
        "Has it been still?",
        "Did it stay put?",
        "did the cap remain in place?",
        "Did it rest?",
        "Has the grip held?",
    ],
)
def test_what_is_stable_holds_still(question):
    assert in_known_words(question) == "Is it holding still?"


@pytest.mark.parametrize(
    ("question", "known"),
    [
        ("Is it moving straight?", "Is it sliding?"),
        ("in a straight line?", "Is it sliding?"),
        ("Does it go round?", "Is it turning?"),
        ("moving in a circle?", "moving in a circle?"),
        ("Is the cap going round and round?", "Is it turning?"),
        ("Along which axis?", OPEN_QUESTION),
        ("along which axis does it slide?", OPEN_QUESTION),
        ("Stationary?", "Is it holding still?"),
    ],
)
def test_the_path_of_a_motion_is_its_kind(question, known):
    assert in_known_words(question) == known


@pytest.mark.parametrize(
    "question",
    [
        "Describe it",
        "What's the label?",
        "Is the rotation positive or negative?",
        "Summary?",
        "Status report",
        "summarise",
    ],
)
def test_a_report_tells_the_motion(question):
    assert in_known_words(question) == OPEN_QUESTION


def test_how_secure_a_hold_is_is_told_by_its_motion_without_a_verdict():
    assert in_known_words("Is the hold secure?") == "Which way is it moving?"


@pytest.mark.parametrize(
    "question",
    [
        "any slip?",
        "Slip detected?",
        "Do you notice any slip?",
        "is there slip",
        "Is there any slippage?",
        "so, did you feel a slip?",
        "slip, yes or no?",
        "Detect slip.",
        "Slip detection: yes or no?",
        "gross slip?",
    ],
)
def test_slip_is_asked_as_a_slide(question):
    assert in_known_words(question) == "Is it slipping?"


@pytest.mark.parametrize(
    "question", ["does it slip in rotation?", "Is there rotational slip?", "torsional slip?"]
)
def test_slip_that_is_called_a_rotation_is_asked_as_a_turn(question):
    assert in_known_words(question) == "Is it turning?"


@pytest.mark.parametrize("question", ["Anything happening?", "Did something change?"])
def test_what_happens_is_asked_as_a_motion(question):
    assert in_known_words(question) == "Is it moving at all?"


@pytest.mark.parametrize(
    "question",
    [
        "Has the object left the left side?",
        "Is the cup empty?",
        "Did I lose the game, or the object?",
        "Do you have the time?",
        "Is it held still?",
        "Is it being pressed in?",
        "Is it pressing into the gel?",
        "Is it slipping to the left?",
        "Is the slip to the right?",
        "How far did it slip?",
        "Which way does the gripper go when empty?",
        "Is the gripper stable and the object turning?",
        "Did the force drop?",
        "Did the temperature drop?",
        "Has the light settled?",
        "Did the image settle?",
        "Has the confidence dropped?",
        "Has the contact dropped?",
        "describe the shear",
    ],
)
def test_other_questions_stay_as_they_are(question):
    assert in_known_words(question) == question


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_otherwise(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=20):
            assert in_known_words(asked.question) == asked.question


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("Any slip?", True),
        ("it slipped", True),
        ("the slippery cap turns", False),
        ("slide", False),
    ],
)
def test_a_motion_called_slip_is_known(text, names):
    assert names_slip(text) is names


@pytest.mark.parametrize(
    ("question", "known"),
    [
        ("do we have contact", "Is anything touching the gel?"),
        ("Is there anything in the hand?", "Is anything touching the gel?"),
        ("Got it?", "Is anything touching the gel?"),
        ("Got it.", "Got it."),
        ("moving around?", "Is it moving at all?"),
        ("is it gone?", "Has contact been lost?"),
        ("did slip occur", "Is it slipping?"),
        ("has slippage started?", "Is it slipping?"),
        ("is slip occurring", "Is it slipping?"),
    ],
)
def test_contact_in_the_words_of_a_radio(question, known):
    assert in_known_words(question) == known
