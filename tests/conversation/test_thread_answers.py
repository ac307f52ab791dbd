"""A thread is the object's: what the sensor does tightens nothing, and changes no thread."""

from dataclasses import replace

import pytest

from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.motion_answers import RuleInput, answer_from_motion
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import ROTATIONS, Motion

SCREW = FrameSpec(thread="right", contact_side="head")


def told(question, motion, frame):
    return answer_from_motion(RuleInput("thread", Felt({motion: 0.9}, 1.0), question, frame))


@pytest.mark.parametrize("question", ["What would tighten it?", "Which way loosens it?"])
@pytest.mark.parametrize("thread", ["right", "left"])
def test_which_turn_of_the_object_tightens_it_is_told_whoever_moved(question, thread):
    frame = replace(SCREW, thread=thread)
    of_object = told(question, Motion.LEFT, frame)
    of_sensor = told(question, Motion.LEFT, replace(frame, actor="sensor"))
    assert (of_sensor.text, of_sensor.direction) == (of_object.text, of_object.direction)
    assert of_sensor.frame.actor == "object"


@pytest.mark.parametrize("motion", ROTATIONS)
def test_that_a_sensor_that_turns_tightens_nothing_is_certain(motion):
    answer = told("Is it tightening?", motion, replace(SCREW, actor="sensor"))
    assert (answer.decided, answer.options) == ("neither", {"neither": 1.0})
    held = told("Is it tightening?", Motion.PRESS, SCREW)
    assert held.options == pytest.approx({"neither": 1.0})
