"""What is asked, or left open, about the image itself."""

import numpy as np
import pytest

from geotlm_lm.conversation.frame_questions import (
    asks_frame,
    asks_which_moves,
    frame_to_settle,
    of_another_frame,
)
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    "text",
    [
        "Is the image mirrored?",
        "The image might be mirrored.",
        "I don't know whether the image is mirrored.",
        "Is the camera mounted upside down?",
        "Was the video flipped or not?",
        "I'm not sure if the picture is upright.",
        "Maybe the clip is mirrored",
    ],
)
def test_an_open_fact_is_asked_for(text):
    told = frame_to_settle(text, FrameSpec(viewpoint="object"))
    assert told.startswith("No touch tells whether the image is mirrored")
    assert "seen from the object" in told


@pytest.mark.parametrize(
    "text",
    [
        "Is the cap mirrored?",
        "Mirrored?",
        "If the image is mirrored, which way?",
        "The image is mirrored.",
        "Is the image mirrored, and which way does it go?",
    ],
)
def test_other_texts_ask_for_no_fact(text):
    assert frame_to_settle(text, FrameSpec()) is None


def test_no_template_of_a_mirrored_clip_asks_for_one():
    rng, label = np.random.default_rng(7), MotionLabel(Motion.LEFT)
    for wordings in ("seen", "held_out"):
        for _ in range(200):
            (asked,) = questions_for(label, rng, types=["T14"], wordings=wordings)
            assert frame_to_settle(asked.question, FrameSpec()) is None, asked.question


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ("In which frame is that direction told?", True),
        ("What is the frame of reference?", True),
        ("in what frame is it?", True),
        ("Which reference frame do you use?", True),
        ("In what frame of reference is the answer given?", True),
        ("and which frame is that?", True),
        ("In which frame is it moving?", False),
        ("In which frame does it begin to turn?", False),
        ("Which frame is sharpest?", False),
        ("Which way does it turn in the frame of reference of the camera?", False),
        ("What frame are you using?", True),
        ("which coordinate system is that in", True),
        ("In what frame do you tell it?", True),
        ("What frame does it start to move in?", False),
        ("In which frame does it touch?", False),
        ("Which frames did you use?", False),
        ("What viewpoint shows it turning left?", False),
    ],
)
def test_who_asks_for_the_frame_of_reference_is_understood(text, asks):
    assert asks_frame(text) is asks


@pytest.mark.parametrize(
    ("question", "rest", "name"),
    [
        ("In the world frame, which way does it turn?", "which way does it turn?", "world frame"),
        ("is it clockwise in robot base coordinates?", "is it clockwise?", "robot base coord"),
        ("in the tool frame?", "Which way is it moving?", "tool frame"),
    ],
)
def test_a_frame_that_nothing_tells_of_is_named(question, rest, name):
    asked, said = of_another_frame(question)
    assert asked == rest
    assert name in said


@pytest.mark.parametrize(
    "question",
    [
        "From the gripper's perspective, which way does it turn?",
        "Viewed from above, which way does it turn?",
        "Which way does it turn as seen from the robot?",
        "which way does it turn, looking from the top?",
    ],
)
def test_a_view_that_nothing_tells_of_is_noted(question):
    asked, said = of_another_frame(question)
    assert asked.rstrip("?") == "which way does it turn"
    assert "to that view" in said


@pytest.mark.parametrize(
    "question", ["in the last frame?", "in the camera frame", "seen from behind", "which way?"]
)
def test_other_frames_are_none_of_these(question):
    assert of_another_frame(question) is None


@pytest.mark.parametrize(
    ("question", "asks"),
    [
        ("In which frame?", True),
        ("relative to what?", True),
        ("What is your reference?", True),
        ("Clockwise as seen from where?", True),
        ("Whose left?", True),
        ("What does clockwise mean here?", True),
        ("from which side?", True),
        ("In which frame does it begin to turn?", False),
        ("What does it mean?", False),
        ("Which way is it seen from the left?", False),
        ("From which side does it come?", False),
    ],
)
def test_whose_left_it_is_asks_for_the_frame(question, asks):
    assert asks_frame(question) is asks


@pytest.mark.parametrize(
    ("question", "asks"),
    [
        ("Is it the sensor or the object that moves?", True),
        ("Was it me or the object?", True),
        ("Is it the bottle cap that turns or the sensor?", True),
        ("Which one moved, the sensor or the object?", True),
        ("Did the object turn or the gripper?", True),
        ("Is the object turning or sliding?", False),
        ("Did the sensor turn or slide?", False),
        ("Is the sensor turning or the object sliding?", False),
        ("Is it the sensor or is it still?", False),
        ("Is the sensor or the gripper moving?", False),
        ("Which way did the sensor move?", False),
    ],
)
def test_which_of_the_two_moves_is_known_by_its_words(question, asks):
    assert asks_which_moves(question) is asks


@pytest.mark.parametrize("question", ["And from above?", "From my perspective?"])
def test_a_bare_view_asks_for_the_way(question):
    assert of_another_frame(question)[0] == OPEN_QUESTION
