import numpy as np
import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates

CAMERA = FrameSpec()
MIRRORED = FrameSpec(image_mirrored=True)


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("The camera image is mirrored.", {"image_mirrored": True}),
        ("my video is flipped left to right", {"image_mirrored": True}),
        ("I look from the object's side", {"viewpoint": "object"}),
        ("I\u2019m looking from the other side!", {"viewpoint": "object"}),
        ("seen from behind", {"viewpoint": "object"}),
        ("The sensor moved, not the object.", {"actor": "sensor"}),
        ("I moved the gripper", {"actor": "sensor"}),
        ("the sensor moves and the cap is fixed", {"actor": "sensor"}),
        ("left-hand thread", {"thread": "left"}),
        ("It has a right handed thread.", {"thread": "right"}),
        ("a normal screw", {"thread": "right"}),
        ("It is a normal thread.", {"thread": "right"}),
        ("it has a reversed thread", {"thread": "left"}),
        ("the sensor touches the head", {"contact_side": "head"}),
        ("touched at its shank", {"contact_side": "shank"}),
        ("side grip", {"contact_side": "side"}),
        ("Note that the image is mirrored", {"image_mirrored": True}),
        (
            "right-hand thread, touched at the head",
            {"thread": "right", "contact_side": "head"},
        ),
        (
            "The image is mirrored and the sensor moved, not the cap; left-hand bolt.",
            {"image_mirrored": True, "actor": "sensor", "thread": "left"},
        ),
    ],
)
def test_a_fact_sets_its_field_and_no_other(text, fields):
    stated = read_facts(text, CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(**fields)
    assert (stated.rest, stated.is_stated) == ("", True)


@pytest.mark.parametrize(
    ("text", "before", "after"),
    [
        ("the image is not mirrored", MIRRORED, CAMERA),
        ("I look from the camera", FrameSpec(viewpoint="object"), CAMERA),
        ("the object moved, not the sensor", FrameSpec(actor="sensor"), CAMERA),
        ("reset the frame", FrameSpec(True, "object", "sensor", "head", "left"), CAMERA),
    ],
)
def test_a_fact_is_taken_back(text, before, after):
    assert read_facts(text, before).frame == after


@pytest.mark.parametrize(
    "text",
    [
        "Is the image mirrored?",
        "If the clip were mirrored, which way?",
        "the image is mirrored and blue",
        "left-hand thread or so",
        "the object is still",
        "it moved",
        "the sensor is new",
        "mirrored?",
        "left",
        "",
    ],
)
def test_anything_else_changes_nothing(text):
    stated = read_facts(text, MIRRORED)
    assert stated.frame == stated.lasting == MIRRORED
    assert (stated.rest, stated.is_stated) == (text, False)


def test_a_fact_in_a_sentence_before_the_question_lasts():
    stated = read_facts("I look from the other side. Which way does it turn?", CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(viewpoint="object")
    assert stated.rest == "Which way does it turn?"


def test_a_way_of_telling_before_a_comma_holds_for_its_question_alone():
    stated = read_facts("Seen from the object's side, which way?", CAMERA)
    assert stated.frame == FrameSpec(viewpoint="object")
    assert stated.lasting == CAMERA


def test_a_fact_of_the_world_lasts_even_before_a_comma():
    stated = read_facts("left-hand thread: is it tightening?", CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(thread="left")
    assert stated.rest == "is it tightening?"


@pytest.mark.parametrize("type_id", sorted(set(load_templates().types) - {"T11", "T12"}))
def test_no_question_of_another_type_is_taken_for_a_fact(type_id):
    rng = np.random.default_rng(5)
    for wordings in ("seen", "held_out"):
        for asked in questions_for(
            MotionLabel(Motion.LEFT), rng, types=[type_id], wordings=wordings, per_type=60
        ):
            assert not read_facts(asked.question, CAMERA).is_stated, asked.question
