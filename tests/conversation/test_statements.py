"""A statement about the recording is told from a question where no fact could be read in it."""

import pytest

from geotlm_lm.conversation.statements import states_more


@pytest.mark.parametrize(
    "text",
    [
        "the image is rotated by 90 degrees",
        "The sensor is upside down.",
        "my camera is tilted",
        "No, the gripper was open.",
        "The sensor is mounted on the right finger.",
        "My sensor's cable points up.",
        "The camera sits on the left.",
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
        "the sensor is moving left",
        "my cap is on the right",
    ],
)
def test_other_texts_are_no_statement_about_the_recording(text):
    assert not states_more(text)
