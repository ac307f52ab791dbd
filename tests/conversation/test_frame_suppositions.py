"""What is supposed of the image, a mover or a thread holds for its question alone."""

from dataclasses import replace

import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.core.frame_spec import FrameSpec

CAMERA = FrameSpec()
MIRRORED = FrameSpec(image_mirrored=True)


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("Where would it go if the image were upside down?", "Where does it go?"),
        ("If the camera were mounted upside down, which way?", "which way?"),
        ("if the image had been flipped upside down which way?", "which way?"),
        ("Had the image been upside down, which way?", "which way?"),
        ("Suppose the image is upside down. Which way?", "Which way?"),
        ("If I turned the picture upside down, where would it go?", "where does it go?"),
        ("which way, if you rotate the video by 180 degrees", "which way"),
        ("If I rotated the image 180 degrees clockwise, which way?", "which way?"),
        ("Suppose I flip the picture upside down: which way?", "which way?"),
        ("What if we turned the image on its head?", "Which way does it move?"),
        ("If I had rotated the sensor by 180 degrees, which way?", "which way?"),
        ("Which way, if I turn the gripper 180 degrees?", "Which way?"),
        ("If the sensor had been turned by 180 degrees, where would it go?", "where does it go?"),
        (
            "If the image were upside down, would the cap be turning left?",
            "is the cap turning left?",
        ),
    ],
)
@pytest.mark.parametrize("before", [CAMERA, MIRRORED])
def test_an_image_supposed_upside_down_is_so_for_its_question_alone(text, rest, before):
    stated = read_facts(text, before)
    assert stated.frame == replace(before, image_upside_down=True)
    assert stated.lasting == before
    assert stated.rest == rest


@pytest.mark.parametrize(
    ("text", "is_upside_down"),
    [
        ("If the image were upside down, which way?", True),
        ("Had the image been upside down, which way?", True),
        ("If I turned the picture upside down, which way?", False),
        ("which way, if you rotate the video by 180 degrees", False),
    ],
)
def test_turning_what_is_upside_down_makes_it_upright(text, is_upside_down):
    before = FrameSpec(image_upside_down=True)
    stated = read_facts(text, before)
    assert stated.frame == FrameSpec(image_upside_down=is_upside_down)
    assert stated.lasting == before


def test_facts_beside_a_supposition_hold():
    stated = read_facts(
        "It is a left-hand thread, if the image were upside down, does it tighten?", CAMERA
    )
    assert stated.frame == FrameSpec(thread="left", image_upside_down=True)
    assert stated.lasting == FrameSpec(thread="left")
    assert stated.rest == "does it tighten?"


def test_an_image_that_were_upside_down_holds_for_its_question():
    stated = read_facts("Were the picture upside down, would it be going down?", FrameSpec())
    assert (stated.frame.image_upside_down, stated.lasting) == (True, FrameSpec())
    assert stated.rest == "is it going down?"


@pytest.mark.parametrize(
    ("text", "fields", "rest"),
    [
        (
            "If this were a left-hand thread touched at the head, would it tighten?",
            {"thread": "left", "contact_side": "head"},
            "would it tighten?",
        ),
        (
            "Had the sensor moved instead, would it have gone left?",
            {"actor": "sensor"},
            "has it gone left?",
        ),
        (
            "Supposing the sensor had turned instead, which way would that be?",
            {"actor": "sensor"},
            "Which way does it move?",
        ),
    ],
)
def test_what_is_supposed_of_a_thread_or_a_mover_holds_for_its_question(text, fields, rest):
    stated = read_facts(text, FrameSpec())
    assert (stated.frame, stated.lasting) == (FrameSpec(**fields), FrameSpec())
    assert stated.rest == rest
