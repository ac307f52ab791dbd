"""A turn of the image is read in its sense, and one that is told in part is asked for, not guessed.

Expected senses were found by turning a drawn arrow: see the first test.
"""

import numpy as np
import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.turned_image import unclear_turn
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates

CLOCKWISE = FrameSpec(image_quarter_turn="clockwise")
COUNTERCLOCKWISE = FrameSpec(image_quarter_turn="counterclockwise")
WAYS = {Motion.LEFT: (0, -1), Motion.RIGHT: (0, 1), Motion.UP: (-1, 0), Motion.DOWN: (1, 0)}
"""Steps of (row, column)."""


@pytest.mark.parametrize(("sense", "turns"), [("clockwise", -1), ("counterclockwise", 1)])
@pytest.mark.parametrize("motion", WAYS)
def test_an_image_turned_as_is_said_is_told_as_before_it_was_turned(sense, turns, motion):
    before = np.zeros((5, 5))
    before[2, 2] = 1
    after = np.roll(before, WAYS[motion], (0, 1))
    # rot90 turns an image counterclockwise.
    recorded = [np.argwhere(np.rot90(one, turns))[0] for one in (before, after)]
    step = tuple(recorded[1] - recorded[0])
    seen = next(way for way, steps in WAYS.items() if steps == step)
    stated = read_facts(f"The image is rotated by 90 degrees {sense}.", FrameSpec())
    assert stated.frame.tell(seen) is motion


@pytest.mark.parametrize(
    "text",
    [
        "The image is rotated by 90 degrees clockwise.",
        "the picture was turned 90° clockwise",
        "My video is turned clockwise by 90 degrees",
        "the recording is rotated by 90 cw",
        "the clip is rotated by a quarter turn to the right",
        "the camera image has been rotated 90 deg in the clockwise direction",
        "the video was recorded rotated by ninety degrees clockwise",
        "the image is turned by 270 degrees counter-clockwise",
        "I rotated the image a quarter turn clockwise",
        "we've turned the recording right by 90 degrees",
        # A camera turned counterclockwise sees everything turned clockwise.
        "the camera is rotated 90 degrees to the left",
        "The camera is mounted turned by 90 degrees counterclockwise.",
        "the sensor is mounted 90 degrees anticlockwise",
        "I rotated the camera by 90 degrees ccw",
        "I mounted the sensor rotated by 270 degrees clockwise",
    ],
)
def test_an_image_turned_clockwise_is_read(text):
    stated = read_facts(text, FrameSpec())
    assert stated.frame == stated.lasting == CLOCKWISE
    assert (stated.rest, stated.is_stated) == ("", True)


@pytest.mark.parametrize(
    "text",
    [
        "The image is rotated by 90 degrees counterclockwise.",
        "the picture is turned left by 90 degrees",
        "I rotated the image a quarter turn counterclockwise",
        "the image is turned by 270 degrees clockwise",
        "the camera is turned by 90 degrees clockwise",
        "The gripper is mounted rotated 90 degrees to the right.",
        "I installed the camera turned by 90 degrees clockwise",
    ],
)
def test_an_image_turned_counterclockwise_is_read(text):
    assert read_facts(text, FrameSpec()).lasting == COUNTERCLOCKWISE


@pytest.mark.parametrize(
    ("text", "before", "after"),
    [
        ("the image is turned by 180 degrees clockwise", CLOCKWISE, 180),
        ("I turned the image by 180 degrees", CLOCKWISE, 180),
        ("the sensor is mounted rotated by 180 degrees", COUNTERCLOCKWISE, 180),
        ("the image is upside down", CLOCKWISE, 180),
        ("the image is upright", CLOCKWISE, 0),
        ("the image is not rotated", COUNTERCLOCKWISE, 0),
        ("the image isn't turned by 90 degrees", COUNTERCLOCKWISE, 0),
        ("the sensor is not mounted sideways", CLOCKWISE, 0),
        ("the camera is not rotated", FrameSpec(image_upside_down=True), 0),
        ("reset the frame", CLOCKWISE, 0),
        ("the image is rotated by 90 degrees clockwise", FrameSpec(image_upside_down=True), 90),
        ("the image is rotated by 90 degrees clockwise", COUNTERCLOCKWISE, 90),
    ],
)
def test_what_is_said_last_of_the_turn_holds(text, before, after):
    assert read_facts(text, before).lasting.turn_deg == after


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("If I turned the picture upside down, which way?", 270),
        ("If the image were upside down, which way?", 180),
    ],
)
def test_an_image_supposed_turned_around_is_turned_on_or_stands_on_its_head(text, degrees):
    stated = read_facts(text, CLOCKWISE)
    assert (stated.frame.turn_deg, stated.lasting) == (degrees, CLOCKWISE)


@pytest.mark.parametrize(
    "text",
    [
        "The image is mirrored and rotated by 90 degrees clockwise.",
        "The image is mirrored. The image is rotated by 90 degrees clockwise.",
        "the image is rotated by 90 degrees clockwise, the image is mirrored",
    ],
)
def test_a_mirror_and_a_turn_are_read_together(text):
    frame = FrameSpec(image_mirrored=True, image_quarter_turn="clockwise")
    assert read_facts(text, FrameSpec()).lasting == frame


@pytest.mark.parametrize(
    "text",
    [
        "the image is upside down and the image is rotated by 90 degrees clockwise",
        "the image is rotated by 90 degrees clockwise and mirrored",
        "the image is flipped vertically, the camera is rotated by 90 degrees clockwise",
    ],
)
def test_turns_that_contradict_each_other_or_lack_an_order_are_not_read(text):
    stated = read_facts(text, FrameSpec())
    assert stated.frame.image_quarter_turn is None
    assert unclear_turn(stated.rest).startswith("I turn an image back only where it is said before")


IMAGE, CAMERA = (
    "the image is turned by 90 degrees clockwise",
    "the camera is mounted turned by 90 degrees clockwise",
)


@pytest.mark.parametrize("asks", ["", ". Which way does it slide?", ", which way does it go?"])
@pytest.mark.parametrize(
    ("text", "example"),
    [
        ("The image is rotated by 90 degrees", IMAGE),
        ("the picture is turned by 90", IMAGE),
        ("the image is rotated by -90 degrees", IMAGE),
        ("I rotated the video a quarter turn", IMAGE),
        ("the image is sideways", IMAGE),
        ("the image is mirrored and sideways", IMAGE),
        ("the recording is in portrait", IMAGE),
        ("the image has a 90 degree rotation", IMAGE),
        ("the camera is mounted sideways", CAMERA),
        ("mounted sideways", CAMERA),
        ("I mounted the sensor sideways", CAMERA),
        ("The sensor is mounted at a 90 degree angle", CAMERA),
        ("the camera is rotated by 270 degrees", CAMERA),
        ("the gripper is held sideways", CAMERA),
        ("With the camera turned by 90 degrees", CAMERA),
        ("If I rotated the image by 90 degrees", IMAGE),
        ("If I had rotated the sensor by 90 degrees", CAMERA),
    ],
)
def test_a_turn_without_its_sense_is_asked_for_it(text, example, asks):
    stated = read_facts(text + asks, FrameSpec())
    assert stated.frame == FrameSpec()
    assert unclear_turn(stated.rest) == (
        f"I cannot tell a direction without the way it is turned: say clockwise or "
        f"counterclockwise, such as '{example}'."
    )


@pytest.mark.parametrize("text", ["the image is rotated", "The picture is turned clockwise."])
def test_a_turn_without_its_angle_is_asked_for_it(text):
    assert unclear_turn(text) == (
        f"I cannot tell a direction without knowing how it is turned: say by 90 degrees which way, "
        f"or by 180, such as '{IMAGE}'."
    )


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("The image is rotated by 30 degrees. Which way?", "30"),
        ("my camera is tilted 12.5° clockwise, which way?", "12.5"),
        ("The sensor is mounted rotated by 45 degrees to the left: which way?", "45"),
        ("I turned the picture by 360 degrees", "360"),
    ],
)
def test_another_angle_is_declined(text, degrees):
    stated = read_facts(text, FrameSpec())
    assert not stated.is_stated
    assert unclear_turn(stated.rest) == (
        f"I tell directions for an image turned by 90, 180 or 270 degrees, not by {degrees}: turn "
        f"the recording upright first."
    )


@pytest.mark.parametrize(
    "text",
    [
        "Which way does it slide? The image is rotated by 90 degrees clockwise.",
        "Which way does it slide in the image rotated by 90 degrees clockwise?",
        "If I rotated the image by 90 degrees clockwise, where would it go?",
        "The image is turned 90 degrees clockwise relative to the gripper. Which way?",
        "The sensor is rotated by 90 degrees clockwise. Which way?",
        "Rotate the image by 90 degrees clockwise. Which way does it slide?",
        "Does it slide right, given that the image turned by 90 degrees clockwise?",
    ],
)
def test_a_turn_that_is_told_elsewhere_or_supposed_is_not_passed_over(text):
    stated = read_facts(text, FrameSpec())
    assert not stated.is_stated
    assert unclear_turn(stated.rest).startswith("I turn an image back only where it is said before")


@pytest.mark.parametrize(
    "text",
    [
        "Is the image rotated by 90 degrees?",
        "Do you know if the image is rotated by 90 degrees?",
        "Did it rotate by 90 degrees?",
        "Was the sensor rotated by 90 degrees clockwise?",
        "It slipped when I turned the camera by 20 degrees. Which way?",
        "the sensor was turned by 180 degrees",
        "The camera is turned on. Which way?",
        "the camera is mounted to the left of the gripper. Which way?",
        "the camera is mounted right above the gel. Which way?",
        "the camera is turned towards the gel, which way?",
        "Has the cap in the image turned by 90 degrees?",
        "Which way is the cap turning in the image?",
        "the video is recorded at 25 fps. Which way?",
        "I turned the cap by 90 degrees. Which way?",
        "The object was mounted on its side. Which way?",
        "the image is upside down and blue",
        "The clip turned 90 degrees clockwise, right?",
        "The clip is rotated 90 degrees clockwise, right?",
        "Is it true that the sensor is turned by 30 degrees?",
        "Does the clip show that the sensor is turned 30 degrees?",
        "",
    ],
)
def test_other_words_tell_no_turn_of_the_image(text):
    assert unclear_turn(text) is None


@pytest.mark.parametrize(
    "text",
    [
        "The image is upside down and rotated by 90 degrees clockwise. Which way does it go?",
        "The image is rotated by 90 degrees clockwise and upside down. Which way does it go?",
        "The image is upside down. The image is rotated by 90 degrees clockwise. Which way?",
    ],
)
def test_of_two_turns_one_is_asked_for(text):
    stated = read_facts(text, FrameSpec())
    assert "give one of the two" in unclear_turn(stated.rest, text)


def test_a_clip_that_is_asked_to_have_turned_states_no_fact():
    asked = "The clip is rotated 90 degrees clockwise, right?"
    assert read_facts(asked, FrameSpec()).rest == asked
    stated = read_facts("The clip is rotated 90 degrees clockwise. Up, right?", FrameSpec())
    assert (stated.frame, stated.rest) == (CLOCKWISE, "Up, right?")


@pytest.mark.parametrize("type_id", sorted(load_templates().types))
def test_no_question_tells_a_turn_of_the_image(type_id):
    rng = np.random.default_rng(5)
    for wordings in ("seen", "held_out"):
        for asked in questions_for(
            MotionLabel(Motion.CLOCKWISE, rotation_deg=90.0),
            rng,
            types=[type_id],
            wordings=wordings,
            per_type=60,
        ):
            assert unclear_turn(asked.question) is None, asked.question


@pytest.mark.parametrize(
    "text",
    [
        "My sensor is upside down",
        "The image was recorded with the sensor upside down.",
        "I rotated the sensor by 180 degrees.",
        "The sensor is rotated 180 degrees.",
        "We turned the gripper upside down. Which way?",
    ],
)
def test_of_a_sensor_on_its_head_it_is_asked_how_it_is_mounted(text):
    assert "say 'the sensor is mounted upside down'" in unclear_turn(text)
