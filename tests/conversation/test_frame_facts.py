import numpy as np
import pytest

from geotlm_lm.conversation.frame_facts import read_facts, turn_told_after
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
        ("The image is upside down", {"image_upside_down": True}),
        ("the camera is mounted upside-down", {"image_upside_down": True}),
        ("My camera is rotated by 180 degrees.", {"image_upside_down": True}),
        ("the sensor is mounted on its head", {"image_upside_down": True}),
        ("the picture is turned upside down", {"image_upside_down": True}),
        ("an upside down camera", {"image_upside_down": True}),
        (
            "The image is mirrored and upside down",
            {"image_mirrored": True, "image_upside_down": True},
        ),
        ("The sensor is on its head", {"contact_side": "head"}),
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
        ("0.06 mm per pixel", {"mm_per_px": 0.06}),
        ("The scale is .05 millimetres per px.", {"mm_per_px": 0.05}),
        ("one pixel is 60 microns wide", {"mm_per_px": 0.06}),
        ("A pixel measures 0.1mm", {"mm_per_px": 0.1}),
        ("mm_per_px = 0.0634", {"mm_per_px": 0.0634}),
        ("20 pixels per mm", {"mm_per_px": 0.05}),
        ("The pixel size is 0.06 mm", {"mm_per_px": 0.06}),
        ("the size of a pixel is 60 um per pixel", {"mm_per_px": 0.06}),
        ("Pixels are 0.06 mm wide.", {"mm_per_px": 0.06}),
        (
            "It is 0.06 mm/px and the image is mirrored",
            {"mm_per_px": 0.06, "image_mirrored": True},
        ),
        (
            "right-hand thread, touched at the head",
            {"thread": "right", "contact_side": "head"},
        ),
    ],
)
def test_a_fact_sets_its_field_and_no_other(text, fields):
    stated = read_facts(text, CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(**fields)
    assert (stated.rest, stated.is_stated) == ("", True)


@pytest.mark.parametrize(
    "text",
    [
        "Is the image mirrored?",
        "Is the image upside down?",
        "Can you tell if the image is upside down?",
        "I don't know if the image is upside down, which way does it go?",
        "It slipped when I turned the camera upside down. Which way?",
        "the gripper is turned by 180 degrees",
        "the sensor was turned by 180 degrees",
        "the image is 180 degrees",
        "the image is upside down and blue",
        "If the clip were mirrored, which way?",
        "the image is mirrored and blue",
        "left-hand thread or so",
        "Assume the image is mirrored.",
        "the top of the table is on the sensor",
        "top",
        "the head turns",
        "head?",
        "is the head on the sensor",
        "the thread is a strange one",
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


def test_a_way_of_telling_in_a_sentence_of_its_own_lasts_whatever_follows():
    stated = read_facts("I look from the other side. Left-hand thread, does it tighten?", CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(viewpoint="object", thread="left")
    assert stated.rest == "does it tighten?"


def test_a_fact_in_a_sentence_before_the_question_lasts():
    stated = read_facts("I look from the other side. Which way does it turn?", CAMERA)
    assert stated.frame == stated.lasting == FrameSpec(viewpoint="object")
    assert stated.rest == "Which way does it turn?"


def test_a_way_of_telling_before_a_comma_holds_for_its_question_alone():
    stated = read_facts("Seen from the object's side, which way?", CAMERA)
    assert stated.frame == FrameSpec(viewpoint="object")
    assert stated.lasting == CAMERA


@pytest.mark.parametrize(
    "text", ["0 pixels per mm", "40 mm per pixel", "1e3 mm per pixel", "one pixel is small"]
)
def test_a_pixel_no_camera_has_is_no_fact(text):
    assert read_facts(text, CAMERA).frame == CAMERA


def test_a_number_is_not_cut_at_its_point():
    assert not read_facts("mm per pixel is 1.5 how far did it slide?", CAMERA).is_stated


def test_the_size_of_a_pixel_said_before_a_question_lasts():
    stated = read_facts("One pixel is 0.06 mm. How far did it slide?", CAMERA)
    assert stated.rest == "How far did it slide?"
    assert stated.frame == stated.lasting == FrameSpec(mm_per_px=0.06)


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
            stated = read_facts(asked.question, CAMERA)
            assert not stated.is_stated, asked.question
            assert (stated.frame, stated.rest) == (CAMERA, asked.question)


@pytest.mark.parametrize(
    ("text", "field", "value"),
    [
        ("the image is mirrored horizontally", "image_mirrored", True),
        ("the screw has a left-hand thread", "thread", "left"),
        ("the sensor presses on the head of the screw", "contact_side", "head"),
        ("the object stayed still, the sensor moved", "actor", "sensor"),
        ("the object is held fixed and I move the sensor", "actor", "sensor"),
        ("The gripper moved, the object did not", "actor", "sensor"),
        ("No, the image is mirrored.", "image_mirrored", True),
        ("it's a left-hand thread touched at the head", "contact_side", "head"),
    ],
)
def test_facts_are_read_in_more_words(text, field, value):
    stated = read_facts(text, FrameSpec())
    assert stated.rest == ""
    assert getattr(stated.lasting, field) == value


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("which way does it turn in the camera image?", "which way does it turn?"),
        ("and from the sensor's side?", "Which way does it move?"),
        ("seen from the camera, which way?", "which way?"),
        ("I look at it from behind the sensor", ""),
    ],
)
def test_the_cameras_own_view_is_read_within_a_question(text, rest):
    stated = read_facts(text, FrameSpec(viewpoint="object"))
    assert (stated.frame.viewpoint, stated.rest) == ("sensor", rest)


def test_away_from_the_sensor_is_no_view():
    assert read_facts("is it away from the sensor?", FrameSpec()).rest.endswith("the sensor?")


@pytest.mark.parametrize(
    "text",
    [
        "Seen from the side, which way does it turn?",
        "From the side: which way?",
        "Looking at its side, does it turn?",
        "Viewed from the side, is it moving?",
    ],
)
def test_who_looks_from_the_side_says_nothing_of_what_is_touched(text):
    stated = read_facts(text, FrameSpec())
    assert (stated.lasting.contact_side, stated.rest) == (None, text)


@pytest.mark.parametrize(
    ("text", "side"),
    [
        ("Held at its side.", "side"),
        ("A side grip.", "side"),
        ("The sensor touches the side.", "side"),
        ("Seen from the head.", "head"),
    ],
)
def test_the_side_that_is_touched_is_told(text, side):
    assert read_facts(text, FrameSpec()).lasting.contact_side == side


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        (
            "a standard right-hand thread seen from the head",
            {"thread": "right", "contact_side": "head"},
        ),
        ("I'm touching the head", {"contact_side": "head"}),
        ("My pixel is 0.05 mm.", {"mm_per_px": 0.05}),
        ("Pixel size 0.06 mm.", {"mm_per_px": 0.06}),
        ("The camera hangs upside down.", {"image_upside_down": True}),
        ("image rotated 90 cw", {"image_quarter_turn": "clockwise"}),
        ("I dragged the sensor over a fixed plate.", {"actor": "sensor"}),
        (
            "I hold the nut at its head, normal thread.",
            {"thread": "right", "contact_side": "head"},
        ),
        ("pixel pitch is 60 \u00b5m", {"mm_per_px": 0.06}),
        ("I look through the object", {"viewpoint": "object"}),
        ("viewed from the operator's side, opposite the sensor", {"viewpoint": "object"}),
    ],
)
def test_facts_in_the_words_of_a_workshop_are_read(text, fields):
    assert read_facts(text, FrameSpec()).frame == FrameSpec(**fields)


def test_facts_may_follow_the_question():
    stated = read_facts("Does it tighten? Right-hand thread, touched at the head.", FrameSpec())
    assert stated.frame == FrameSpec(thread="right", contact_side="head")
    assert stated.rest == "Does it tighten?"


def test_a_turn_told_after_a_question_is_noticed():
    assert turn_told_after("Which way does it go? The image is upside down.")
    assert not turn_told_after("Which way does it go? The image is mirrored.")
    assert not turn_told_after("Is the image upside down?")
