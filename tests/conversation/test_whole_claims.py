"""Denials, kinds of motion named by nouns, and two clauses: what they are true of."""

import numpy as np
import pytest

from geotlm_lm.conversation.whole_claims import whole_claim
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for

EVERY, TURNS, SLIDING = frozenset(Motion), frozenset(ROTATIONS), frozenset(SLIDES)
AT_REST = frozenset({Motion.STILL, Motion.NONE})
NO_TURN, NO_SLIDE = EVERY - TURNS, EVERY - SLIDING


@pytest.mark.parametrize(
    ("question", "motions"),
    [
        ("It is not moving, right?", AT_REST),
        ("Is it correct that nothing moves?", AT_REST),
        ("Nothing happens, does it?", AT_REST),
        ("Is the gripper not moving?", AT_REST),
        ("I think it isn't moving. Correct?", AT_REST),
        ("No motion at all, true?", AT_REST),
        ("Is it still not moving?", AT_REST),
        ("It's not slipping, right?", NO_SLIDE),
        ("No slip, correct?", NO_SLIDE),
        ("It isn't sliding, is it?", NO_SLIDE),
        ("Am I right that it does not slide?", NO_SLIDE),
        ("Can I rule out that it slides?", NO_SLIDE),
        ("Can we exclude slipping?", NO_SLIDE),
        ("Is the contact not slipping?", NO_SLIDE),
        ("It's not rotating, right?", NO_TURN),
        ("Is it true that it does not rotate?", NO_TURN),
        ("there is no rotation, yes or no", NO_TURN),
        ("Is it wrong to say that it turns counterclockwise?", EVERY - {Motion.COUNTERCLOCKWISE}),
        ("Is it false that it slides left?", EVERY - {Motion.LEFT}),
        ("Am I wrong that it is turning?", NO_TURN),
        ("Is it wrong to say that it does not move?", EVERY - AT_REST),
        ("Is it touching but not moving?", {Motion.STILL}),
        ("Is the object in contact with the sensor and not moving?", {Motion.STILL}),
        ("It turns but does not slide, right?", TURNS),
        ("It is not slipping, it is turning?", TURNS),
        ("is it pressing but not turning?", {Motion.PRESS}),
    ],
)
def test_a_denial_is_true_of_all_that_does_not_what_is_denied(question, motions):
    claim = whole_claim(question)
    assert claim.motions == motions
    assert claim.is_denied


@pytest.mark.parametrize(
    ("question", "motions"),
    [
        ("rotation: yes/no?", TURNS),
        ("Any rotation?", TURNS),
        ("rotation detected?", TURNS),
        ("Can you detect rotation?", TURNS),
        ("do you feel any twist?", TURNS),
        ("torsional slip?", TURNS),
        ("any rotational slip", TURNS),
        ("slide: yes/no?", SLIDING),
        ("Any translation?", SLIDING),
        ("translation detected?", SLIDING),
        ("slippage visible?", SLIDING),
        ("Is the movement horizontal?", {Motion.LEFT, Motion.RIGHT}),
        ("was the motion purely vertical", {Motion.UP, Motion.DOWN}),
        ("Is this vertical?", {Motion.UP, Motion.DOWN}),
        ("Was this sideways?", {Motion.LEFT, Motion.RIGHT}),
        ("Is there horizontal motion?", {Motion.LEFT, Motion.RIGHT}),
        ("Any sideways movement?", {Motion.LEFT, Motion.RIGHT}),
        ("Is there any vertical slip at all?", {Motion.UP, Motion.DOWN}),
        ("Does it slide while being pressed?", SLIDING),
        ("Does it slide while I push it?", SLIDING),
        ("Does it turn while it is pressed?", TURNS),
        ("Is it turning clockwise while touching?", {Motion.CLOCKWISE}),
        ("Does it rotate while it is lifted?", frozenset()),
        ("Is it turning while sliding?", frozenset()),
    ],
)
def test_a_kind_or_two_things_at_once_are_claimed_whole(question, motions):
    claim = whole_claim(question)
    assert claim.motions == motions
    assert not claim.is_denied


@pytest.mark.parametrize(
    "question",
    [
        "Is it not turning left?",
        "It isn't moving right, is it?",
        "Isn't it moving?",
        "Doesn't it slide?",
        "Is it not touching the gel?",
        "No contact?",
        "Is the motion no contact?",
        "nothing or not?",
        "Is it moving or not?",
        "Is it moving, or is it not?",
        "Why does it not move?",
        "Which way does it not move?",
        "Not the direction, just the kind of motion.",
        "Is it turning without slipping?",
        "Is it no longer moving?",
        "Has it stopped, not moving?",
        "Is it not only sliding but turning?",
        "It did not turn 5 degrees, right?",
        "If it does not move, what then?",
        "I did not touch it while it moved.",
        "Is the image not mirrored?",
        "Any movement?",
        "any idea?",
        "rotation or slide?",
        "Is it sliding?",
        "Does it slide while it rains?",
        "A) slips B) does not slip",
        "",
    ],
)
def test_other_questions_claim_nothing_here(question):
    assert whole_claim(question) is None


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_read_as_a_whole_claim(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=12):
            assert whole_claim(asked.question) is None, asked


@pytest.mark.parametrize(
    "question",
    [
        "Is it pressed but not moving?",
        "Is it pushed, not moving?",
        "Is it pressing and not moving?",
    ],
)
def test_what_would_contradict_itself_is_left_to_the_model(question):
    assert whole_claim(question) is None or whole_claim(question).motions
