"""How far in x and in y: the parts of one amount, in the frame it is told in."""

from dataclasses import replace

import pytest

from geotlm_lm.answering.abstention import neutral_answer
from geotlm_lm.answering.amounts import Amount
from geotlm_lm.answering.components import split_into_components
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from tests.answering.scripted import measuring, recording
from tests.answering.test_measured_amounts import encoded

CAMERA = FrameSpec()


def told(clip, motion, frame=CAMERA, unit="px"):
    amount = Amount(20.0, unit, 15.0, 25.0, 0.9)
    answer = replace(neutral_answer(clip, amount.sentence(), "magnitude", frame), amount=amount)
    return split_into_components(clip, answer, motion, frame).text


@pytest.mark.parametrize(
    ("frame", "way", "parts"),
    [
        ({}, "Right, in the camera image.", "+16 in x and -12 in y"),
        ({"image_mirrored": True}, "Left, in the camera image with the mirror", "-16 in x and -12"),
        ({"viewpoint": "object"}, "Left, seen from the object's side.", "-16 in x and -12 in y"),
        ({"actor": "sensor"}, "The sensor goes left,", "-16 in x and +12 in y"),
        ({"image_upside_down": True}, "Left, in the camera image turned", "-16 in x and +12 in y"),
        ({"image_quarter_turn": "clockwise"}, "Up, in the camera image", "-12 in x and -16 in y"),
    ],
)
def test_parts_are_told_in_the_frame(frame, way, parts):
    text = told(encoded(224, 224, 0.8, -0.6), Motion.RIGHT, FrameSpec(**frame))
    assert text.startswith(way)
    assert parts in text
    assert text.endswith("About 20 pixels of sliding, likely 15 to 25.")


def test_parts_are_of_the_recordings_own_pixels():
    # One of the square image is 640 / 224 of them wide and 480 / 224 high.
    assert "+17 in x and -10 in y" in told(encoded(480, 640, 0.8, -0.6), Motion.RIGHT)


def test_parts_of_a_speed_are_per_second():
    text = told(encoded(224, 224, 1.0, 0.0), Motion.RIGHT, unit="px/s")
    assert "+20 in x and +0 in y, x to the right and y down, in pixels per second." in text


def test_no_parts_are_told_where_the_alignments_go_another_way():
    assert "in x" not in told(encoded(224, 224, 0.0, 1.0), Motion.RIGHT)


def test_what_turns_has_no_parts(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "How much in x and in y?")
    assert answer.text.startswith(
        "It does not slide: it goes clockwise in the camera image. About 13 degrees"
    )
