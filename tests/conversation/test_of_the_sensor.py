"""Amounts and verdicts of the sensor's motion are those of the object relative to it."""

import numpy as np
import pytest

from geotlm_lm.conversation.of_the_sensor import as_of_it, names_the_object
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "of_it"),
    [
        ("How far did the sensor move?", "how far did it move?"),
        ("By how many degrees did the gripper rotate?", "by how many degrees did it rotate?"),
        ("How fast does the sensor turn?", "how fast does it turn?"),
        ("Did the sensor move left?", "did it move left?"),
        ("Does the sensor move at all?", "does it move at all?"),
        ("Did the gripper itself turn clockwise?", "did it turn clockwise?"),
        ("Has the gripper turned?", "has it turned?"),
        ("Has my finger slipped?", "has it slipped?"),
        ("Has the wrist moved?", "has it moved?"),
        ("Total rotation of the sensor?", "total rotation of it?"),
        ("slip of the gripper in mm", "slip of it in mm"),
        ("Has the sensor been touched?", None),
        ("Which way did the sensor move?", None),
        ("And the sensor?", None),
        ("How far did it move?", None),
        ("Did the cap move left on the sensor?", None),
    ],
)
def test_what_is_asked_of_the_sensor_is_told_of_it(text, of_it):
    assert as_of_it(text) == of_it


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_template_about_the_sensor_s_own_way_is_taken(wordings):
    rng, label = np.random.default_rng(5), MotionLabel(Motion.LEFT)
    for _ in range(200):
        (asked,) = questions_for(label, rng, types=["T12"], wordings=wordings)
        assert as_of_it(asked.question) is None, asked.question


def test_a_question_may_name_the_object():
    assert names_the_object("Which way did the object move?")
    assert names_the_object("How far does the object itself slide?")
    assert not names_the_object("Which way did it move?")
    assert not names_the_object("Which way did the sensor move past the object?")
