"""Mistyped kinds of motion are put right, and no word that means something else."""

import numpy as np
import pytest

from geotlm_lm.conversation.spelling import as_words, spelt
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("is the object sliping", "is the object slipping"),
        ("Is it sldiing?", "Is it sliding?"),
        ("which way is it truning", "which way is it turning"),
        ("rotaing?", "rotating?"),
        ("Is it Twistng?", "Is it twisting?"),
        ("did it slipp to the rigth?", "did it slip to the right?"),
        ("is it moveing rigth?", "is it moving right?"),
        ("lfet or rihgt", "left or right"),
        ("does it trun", "does it turn"),
        ("is it going downn?", "is it going down?"),
        ("is it turning clokwise?", "is it turning clockwise?"),
    ],
)
def test_a_mistyped_motion_is_put_right(text, meant):
    assert spelt(text) == meant


@pytest.mark.parametrize(
    "text",
    [
        "flipping the clip, which way?",
        "Is the rotation clockwise?",
        "IS IT TURNING?",
        "skipping or sliding",
        "Is the tuning knob turning?",
        "is it returning?",
        "Is it thinning?",
        "during the touch",
        "Is it unmoving?",
        "Is it removing the object?",
        "is it untwisting",
        "I felt the light at night",
        "is it the lift or the leaf",
        "otherwise it slides",
        "is the trunk sliding",
        "does it turn anticlockwise",
        "she slid, it stills",
    ],
)
def test_other_words_stay(text):
    assert spelt(text) == text


def test_questions_of_the_templates_without_slips_stay():
    rng = np.random.default_rng(7)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings="held_out", per_type=8):
            assert spelt(asked.question) == asked.question


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("SLIP_DIR?", "SLIP DIR?"),
        ("is_rotating?", "is it rotating?"),
        ("rotation_direction", "rotation direction"),
        ("was_sliding_left?", "was it sliding left?"),
        ("is rotating?", "is rotating?"),
        ("_", "_"),
        ("isTurning?", "is it turning?"),
        ("hasSlipped()", "has it slipped"),
        ("didSlip()", "did it slip"),
        ("isNotTurning()", "is it not turning"),
        ("is_still_turning", "is it still turning"),
        ("isGripperTurning", "is the gripper turning"),
        ("is_it_turning", "is it turning"),
        ("label != left", "label is not left"),
        ("Is the CapTurning?", "Is the CapTurning?"),
    ],
)
def test_an_identifier_is_read_as_words(text, words):
    assert as_words(text) == words
