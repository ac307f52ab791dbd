"""Changes that a question supposes, alone and together: each is a change of sign."""

import numpy as np
import pytest

from geotlm_lm.conversation.changes import asked_changes, claimed_of_change, claimed_remedy
from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.retell import CAMERA, Felt, retell
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates

CW, CCW, LEFT, RIGHT, UP, DOWN = (
    Motion.CLOCKWISE,
    Motion.COUNTERCLOCKWISE,
    Motion.LEFT,
    Motion.RIGHT,
    Motion.UP,
    Motion.DOWN,
)
TYPES = {"T11": "viewpoint", "T12": "actor", "T14": "mirrored", "T15": "reversed", "T21": "undo"}


def told(question, motion, frame=CAMERA):
    shares = {motion: 0.9, Motion.NONE: 0.1}
    return retell(Felt(asked_kind(question), motion, question, frame, shares))


@pytest.mark.parametrize(
    ("question", "motion", "direction"),
    [
        ("Which way do I have to move the sensor to bring it back?", LEFT, LEFT),
        ("What motion of the sensor undoes it?", LEFT, LEFT),
        ("In which direction should the gripper move to counteract the slip?", LEFT, LEFT),
        ("Which way should I rotate the wrist to counteract it?", CW, CW),
        ("Which way must I move the sensor back?", UP, UP),
        ("How must I turn the finger to cancel it?", CCW, CCW),
        ("Which turn of the robot arm would undo it?", CCW, CCW),
        ("Which motion of the object undoes it?", LEFT, RIGHT),
        ("Which way undoes the slide on the sensor?", LEFT, RIGHT),
        ("If you flip the image vertically, where does it go?", LEFT, LEFT),
        ("If you flip the image vertically, where does it go?", UP, DOWN),
        ("If I flip the picture vertically, where does it go?", CW, CCW),
        ("If the video were mirrored top to bottom, which way would it go?", UP, DOWN),
        ("And after a vertical flip?", DOWN, UP),
        ("If it was flipped horizontally, which way?", LEFT, RIGHT),
        ("If it was flipped horizontally and vertically, which way?", LEFT, RIGHT),
        ("If it was flipped horizontally and vertically, which way?", CW, CW),
        ("If it was flipped upside down, which way?", UP, DOWN),
        ("And upside down?", UP, DOWN),
        ("If it was mirrored and played backwards?", CW, CW),
        ("If it was both upside down and played backwards?", LEFT, LEFT),
        ("Seen from the object's side and played backwards?", LEFT, LEFT),
        ("In reverse, which way does the sensor move?", LEFT, LEFT),
        ("If the image were mirrored and the sensor moved instead?", LEFT, LEFT),
        ("If mirrored, which way does the sensor turn?", CW, CW),
        ("What undoes it, seen from the object's side?", LEFT, LEFT),
        ("What would undo it if the image is mirrored?", LEFT, LEFT),
        ("What would undo it if the image is mirrored?", UP, DOWN),
        ("Mirrored, in reverse, seen from the other side?", LEFT, RIGHT),
        ("Which way in the mirrored image of the sensor?", LEFT, RIGHT),
        ("In reverse, which way does the part on the gel go?", LEFT, RIGHT),
    ],
)
def test_every_change_of_a_question_counts(question, motion, direction):
    assert told(question, motion).direction == direction


@pytest.mark.parametrize(
    ("question", "text"),
    [
        (
            "If it was mirrored and played backwards?",
            "Left, in the camera image, if the clip is mirrored and played backwards.",
        ),
        (
            "If you flip the image vertically, where does it go?",
            "Left, in the camera image, if the clip is flipped top to bottom.",
        ),
        (
            "If it was both upside down and played backwards?",
            "Left, in the camera image turned by 180 degrees, played backwards.",
        ),
        (
            "In reverse, where does the sensor go?",
            "The sensor goes left, in the camera image, played backwards.",
        ),
        (
            "What motion of the sensor undoes it?",
            "Moving the sensor left undoes it, in the camera image.",
        ),
        (
            "What undoes it, seen from the object's side?",
            "Moving left undoes it, seen from the object's side.",
        ),
    ],
)
def test_every_change_is_named(question, text):
    assert told(question, LEFT).text == text


@pytest.mark.parametrize("motion", DIRECTED)
def test_a_sensor_undoes_a_motion_the_way_it_went(motion):
    question = "Which motion of the sensor undoes it?"
    assert told(question, motion).direction == motion
    frame = FrameSpec(actor="sensor")
    assert told("What undoes it?", motion, frame).direction == motion


@pytest.mark.parametrize(
    ("question", "motion", "text", "decided"),
    [
        (
            "Should I turn it clockwise to undo that?",
            CW,
            "No, moving counterclockwise undoes it, in the camera image.",
            "no",
        ),
        (
            "Would turning it clockwise undo it?",
            CCW,
            "Yes, moving clockwise undoes it, in the camera image.",
            "yes",
        ),
        (
            "Should I move the sensor left to undo it?",
            LEFT,
            "Yes, moving the sensor left undoes it, in the camera image.",
            "yes",
        ),
        ("Does lifting undo it?", Motion.PRESS, "Yes, lifting off undoes it.", "yes"),
        (
            "Would turning it clockwise undo it?",
            Motion.STILL,
            "No, there is nothing to undo: it is touching but not moving.",
            "no",
        ),
    ],
)
def test_a_remedy_that_is_named_is_judged(question, motion, text, decided):
    answer = told(question, motion)
    assert (answer.text, answer.decided) == (text, decided)
    assert sum(answer.options.values()) == pytest.approx(1)


@pytest.mark.parametrize(
    "question",
    [
        "Should I move it left or right to undo it?",
        "Which way should I turn it to undo that?",
        "What undoes a slide to the left?",
        "Should I turn it back?",
    ],
)
def test_no_remedy_is_named_in_an_open_question(question):
    assert claimed_remedy(question) is None


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
@pytest.mark.parametrize("type_id", TYPES)
def test_a_question_of_the_templates_supposes_one_change(type_id, wordings):
    rng, kind = np.random.default_rng(11), TYPES[type_id]
    assert load_templates().types[type_id].kind == kind
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, types=[type_id], wordings=wordings, per_type=8):
            assert asked_changes(asked.question, kind).names == {kind}, asked
            assert claimed_remedy(asked.question) is None, asked


@pytest.mark.parametrize(
    ("question", "claims"),
    [
        ("If the image were mirrored, would it slide left?", {Motion.LEFT}),
        ("Is it clockwise if flipped left to right?", {Motion.CLOCKWISE}),
        ("played backwards, is it turning?", set(ROTATIONS)),
        ("If the image were mirrored, which way would it slide?", set()),
        ("mirrored, is it going left or right?", set()),
        ("and mirrored?", set()),
    ],
)
def test_a_claim_of_the_changed_clip_is_read(question, claims):
    assert claimed_of_change(question) == claims


def test_who_pushes_asks_for_no_press():
    assert claimed_remedy("To bring it back, should I push left?") == Motion.LEFT
    assert claimed_remedy("should I press to undo it?") == Motion.PRESS
