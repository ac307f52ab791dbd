"""Facts about a thread and the end of it that touches, in the words people have for them."""

from dataclasses import replace

import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.core.frame_spec import FrameSpec

CAMERA = FrameSpec()


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        (
            "Assume a right-hand thread and that the sensor touches the head.",
            {"thread": "right", "contact_side": "head"},
        ),
        (
            "The cap's top faces the sensor. Right-hand thread.",
            {"thread": "right", "contact_side": "head"},
        ),
        ("standard right-handed thread", {"thread": "right"}),
        (
            "The bolt head presses into the gel and the thread is a standard one.",
            {"thread": "right", "contact_side": "head"},
        ),
        (
            "The head of the screw touches the gel. It has a right-hand thread.",
            {"thread": "right", "contact_side": "head"},
        ),
        ("left hand thread, head", {"thread": "left", "contact_side": "head"}),
        ("shank", {"contact_side": "shank"}),
        ("the tip of my bolt is on the sensor", {"contact_side": "shank"}),
        ("the sensor presses on its top", {"contact_side": "head"}),
        (
            "a regular thread, the nut's top is pressed against the gel",
            {"thread": "right", "contact_side": "head"},
        ),
        (
            "The image is mirrored and the sensor moved, not the cap; left-hand bolt.",
            {"image_mirrored": True, "actor": "sensor", "thread": "left"},
        ),
    ],
)
def test_a_thread_and_its_end_are_read_in_natural_words(text, fields):
    stated = read_facts(text, CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(**fields)
    assert (stated.rest, stated.is_stated) == ("", True)


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("and with a right-hand thread?", {"thread": "right"}),
        ("what about a normal thread?", {"thread": "right"}),
        ("and if it had a right-hand thread instead?", {"thread": "right"}),
        ("but from the shank?", {"contact_side": "shank"}),
    ],
)
def test_another_thread_is_asked_for_in_one_question_alone(text, fields):
    before = FrameSpec(thread="left", contact_side="head")
    stated = read_facts(text, before)
    assert stated.frame == replace(before, **fields)
    assert stated.lasting == before
    assert stated.rest == "Is it tightening or loosening?"


@pytest.mark.parametrize("text", ["and with the thread?", "with a right-hand thread?", "and left?"])
def test_other_short_questions_suppose_no_thread(text):
    assert not read_facts(text, CAMERA).is_stated


def test_who_asks_for_the_camera_image_alone_asks_openly():
    assert read_facts("and in the camera image?", CAMERA).rest == "Which way does it move?"
    asked = "and in the camera image, is it turning?"
    assert read_facts(asked, CAMERA).rest == asked


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("right-hand thread, sensor on top of the screw head: tightening?", "tightening?"),
        ("Normal thread, head on the sensor. Am I loosening it?", "Am I loosening it?"),
        (
            "normal right-handed nut and the sensor presses on its top. Is it being loosened?",
            "Is it being loosened?",
        ),
    ],
)
def test_thread_and_end_are_read_before_a_question(text, rest):
    stated = read_facts(text, CAMERA)
    assert stated.frame == FrameSpec(thread="right", contact_side="head")
    assert stated.rest == rest
