"""A kind of motion or rest, whichever it is."""

import numpy as np
import pytest

from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionClass, MotionLabel
from geotlm_lm.data.questions import questions_for

ROTATION, SLIDE, STILL = MotionClass.ROTATION, MotionClass.SLIDE, MotionClass.STILL


@pytest.mark.parametrize(
    ("question", "kinds"),
    [
        ("Is it slipping or stationary?", {SLIDE, STILL}),
        ("is the cap turning or is it still?", {ROTATION, STILL}),
        ("stick or slip?", {SLIDE, STILL}),
        ("Does it turn, slip or stick?", {ROTATION, SLIDE, STILL}),
        ("sliding, rotating, or at rest?", {ROTATION, SLIDE, STILL}),
    ],
)
def test_the_kinds_are_read(question, kinds):
    assert offered_kinds(question) == kinds


@pytest.mark.parametrize(
    "question",
    [
        "Is it moving or stationary?",
        "Is it slipping?",
        "Is it slipping left or is it still?",
        "A) slipping B) still",
        "Is it pressing or still?",
        "Which clip is slipping or still?",
    ],
)
def test_other_choices_are_not(question):
    assert offered_kinds(question) is None


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_taken_for_one(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert offered_kinds(asked.question) is None
