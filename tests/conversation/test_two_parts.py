"""Texts that ask two things, and what no model is asked; questions of templates are neither."""

import numpy as np
import pytest

from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.statements import states_more
from geotlm_lm.conversation.two_parts import two_parts
from geotlm_lm.conversation.untold import asks_place, untold
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("which way is it turning and how far?", ("which way is it turning", "how far?")),
        (
            "is the lid rotating cw or ccw and by how many degrees?",
            ("is the lid rotating cw or ccw", "how many degrees?"),
        ),
        (
            "First: is there contact? Second: which way does it turn?",
            ("is there contact?", "which way does it turn?"),
        ),
        ("Does it move? How fast?", ("Does it move?", "How fast?")),
        ("Hello there? Which way?", None),
        ("Which way? A) left B) right", None),
        ("Which way? Which direction?", None),
        ("Which way is it turning?", None),
        ("salt and how far?", None),
    ],
)
def test_a_text_is_parted_where_both_parts_ask(text, parts):
    assert two_parts(text) == parts


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_parted_or_taken_for_a_statement(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert two_parts(asked.question) is None, asked
            assert not states_more(asked.question), asked
            assert not asks_place(asked.question), asked
            is_declined = asked_kind(asked.question) is None and untold(asked.question)
            assert not is_declined or asked.type_id == "T17", asked


@pytest.mark.parametrize(
    "text",
    [
        "the image is rotated by 90 degrees",
        "The sensor is upside down.",
        "my camera is tilted",
        "No, the gripper was open.",
    ],
)
def test_a_statement_about_the_recording_is_none_about_the_motion(text):
    assert states_more(text)


@pytest.mark.parametrize(
    "text",
    [
        "the cap turned clockwise",
        "the motion of the gripper",
        "the sensor moves which way",
        "is the image mirrored?",
        "I want to know whether the sensor moved",
        "the object is red",
        "it is touching the gel",
        "I think it moved on the sensor.",
        "We have an image of a screw, is it loosening",
        "gripper",
    ],
)
def test_other_texts_are_no_statement_about_the_recording(text):
    assert not states_more(text)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("When does it start to move?", "watch"),
        ("At what frame does the rotation begin?", "watch"),
        ("how deep is the indentation?", "depth"),
        ("In which direction is the force?", "force"),
        ("Is the rotation about the z axis positive?", "axis"),
        ("help", "Ask how"),
        ("thanks!", "Ask how"),
        ("What can you do?", "Ask how"),
    ],
)
def test_what_is_never_told_is_declined_with_what_is(text, word):
    assert word in untold(text)


@pytest.mark.parametrize(
    "text",
    ["Which way?", "When did it start to turn left?", "Does it help to turn it?", "stop it?"]
    + [
        "When touched, which way does it move?",
        "Is pressure increasing?",
        "Under pressure, where?",
    ],
)
def test_other_questions_are_left_to_the_model(text):
    assert untold(text) is None


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ("Where is the contact?", True),
        ("is the contact at the top or the bottom?", True),
        ("where does the cap touch?", True),
        ("where is it going?", False),
        ("where is the object moving?", False),
        ("which way does the contact point move?", False),
        ("is the contact at rest?", False),
        ("is the contact on the move?", False),
        ("is the contact area getting larger?", False),
        ("is there contact?", False),
    ],
)
def test_who_asks_for_the_place_of_the_contact_is_understood(text, asks):
    assert asks_place(text) is asks
