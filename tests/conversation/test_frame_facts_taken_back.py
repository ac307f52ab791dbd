"""Facts of the frame are taken back, or were never said."""

import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.core.frame_spec import FrameSpec

CAMERA = FrameSpec()
MIRRORED = FrameSpec(image_mirrored=True)


@pytest.mark.parametrize(
    ("text", "before", "after"),
    [
        ("the image is not mirrored", MIRRORED, CAMERA),
        ("I look from the camera", FrameSpec(viewpoint="object"), CAMERA),
        ("the object moved, not the sensor", FrameSpec(actor="sensor"), CAMERA),
        ("the image is not upside down", FrameSpec(image_upside_down=True), CAMERA),
        ("the camera is upright", FrameSpec(image_upside_down=True), CAMERA),
        ("the sensor isn't mounted upside down", FrameSpec(image_upside_down=True), CAMERA),
        ("reset the frame", FrameSpec(mm_per_px=0.06), CAMERA),
        ("reset the frame", FrameSpec(True, "object", "sensor", "head", "left", True), CAMERA),
    ],
)
def test_a_fact_is_taken_back(text, before, after):
    assert read_facts(text, before).frame == after


@pytest.mark.parametrize(
    "text",
    [
        "No left-hand thread.",
        "No mirrored image.",
        "The robot moved and the sensor stayed still.",
        "the sensor is upside down",
        "I rotated the sensor by 180 degrees. Which way does it go?",
        "If I held the sensor upside down, which way does it go?",
        "Do you know if I rotated the sensor by 180 degrees?",
        "If I rotated the cap by 180 degrees, which way?",
    ],
)
def test_what_denies_a_fact_or_is_about_the_holder_alone_is_not_read(text):
    assert not read_facts(text, FrameSpec()).is_stated


@pytest.mark.parametrize(
    ("text", "before", "after"),
    [
        ("the sensor is mounted the right way up", FrameSpec(image_upside_down=True), CAMERA),
        ("No, the camera is mounted upright.", FrameSpec(image_upside_down=True), CAMERA),
        ("the image is right side up again", FrameSpec(image_upside_down=True), CAMERA),
        ("Actually it is not mirrored.", MIRRORED, CAMERA),
        ("It's not mirrored any more", MIRRORED, CAMERA),
        ("The image is no longer mirrored.", MIRRORED, CAMERA),
        ("I look from the sensor's side again.", FrameSpec(viewpoint="object"), CAMERA),
        ("Forget the pixel size.", FrameSpec(mm_per_px=0.06), CAMERA),
        ("reset the scale", FrameSpec(mm_per_px=0.06), CAMERA),
        ("reset", MIRRORED, CAMERA),
        ("Forget everything.", FrameSpec(True, "object"), CAMERA),
        ("I'm looking at the object from the other side", CAMERA, FrameSpec(viewpoint="object")),
    ],
)
def test_a_fact_is_taken_back_in_ordinary_words(text, before, after):
    stated = read_facts(text, before)
    assert (stated.lasting, stated.rest) == (after, "")


@pytest.mark.parametrize(
    "text", ["it is flipped", "it is not upside down", "reset the gripper", "forget it", "again"]
)
def test_what_may_be_said_of_the_object_takes_nothing_back(text):
    assert not read_facts(text, MIRRORED).is_stated
