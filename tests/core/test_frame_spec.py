"""How a motion reads from another frame of reference, and when a thread tightens."""

import itertools
import json

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion

CW, CCW = Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE
LEFT, RIGHT, UP, DOWN = Motion.LEFT, Motion.RIGHT, Motion.UP, Motion.DOWN
SEEN = (CW, LEFT, UP, Motion.PRESS, Motion.STILL)
TOLD = {
    # (image_mirrored, viewpoint, actor): what CW, LEFT, UP, PRESS, STILL are told as
    (False, "sensor", "object"): (CW, LEFT, UP, Motion.PRESS, Motion.STILL),
    (True, "sensor", "object"): (CCW, RIGHT, UP, Motion.PRESS, Motion.STILL),
    (False, "object", "object"): (CCW, RIGHT, UP, Motion.PRESS, Motion.STILL),
    (True, "object", "object"): (CW, LEFT, UP, Motion.PRESS, Motion.STILL),
    (False, "sensor", "sensor"): (CCW, RIGHT, DOWN, Motion.PRESS, Motion.STILL),
    (True, "sensor", "sensor"): (CW, LEFT, DOWN, Motion.PRESS, Motion.STILL),
    (False, "object", "sensor"): (CW, LEFT, DOWN, Motion.PRESS, Motion.STILL),
    (True, "object", "sensor"): (CCW, RIGHT, DOWN, Motion.PRESS, Motion.STILL),
}
FRAMES = [
    (*frame, None, None, is_upside_down)
    for frame in itertools.product((False, True), ("sensor", "object"), ("object", "sensor"))
    for is_upside_down in (False, True)
]


@pytest.mark.parametrize("frame", TOLD)
def test_every_frame_tells_the_motion_as_it_is_seen_from_there(frame):
    spec = FrameSpec(*frame)
    assert tuple(spec.tell(motion) for motion in SEEN) == TOLD[frame]


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("motion", Motion)
def test_telling_twice_gives_the_camera_image_back(frame, motion):
    spec = FrameSpec(*frame)
    assert spec.tell(spec.tell(motion)) == motion


@pytest.mark.parametrize("frame", TOLD)
def test_an_image_upside_down_turns_slides_around_and_leaves_turns(frame):
    turn, left, up, press, still = TOLD[frame]
    opposite = {LEFT: RIGHT, RIGHT: LEFT, UP: DOWN, DOWN: UP}
    spec = FrameSpec(*frame, image_upside_down=True)
    expected = (turn, opposite[left], opposite[up], press, still)
    assert tuple(spec.tell(motion) for motion in SEEN) == expected


@pytest.mark.parametrize(
    ("contact_side", "thread", "motion", "tightens"),
    [
        ("head", "right", CW, True),
        ("head", "right", CCW, False),
        ("head", "left", CW, False),
        ("head", "left", CCW, True),
        ("shank", "right", CW, False),
        ("shank", "right", CCW, True),
        ("shank", "left", CW, True),
        ("shank", "left", CCW, False),
        ("side", "right", CW, None),
        ("side", "left", CCW, None),
        (None, "right", CW, None),
        ("head", None, CW, None),
        ("head", "right", LEFT, None),
        ("head", "right", Motion.STILL, None),
    ],
)
def test_a_thread_tightens_by_side_hand_and_turn(contact_side, thread, motion, tightens):
    spec = FrameSpec(contact_side=contact_side, thread=thread)
    assert spec.tightens(motion) is tightens


def test_a_mirrored_image_inverts_tightening():
    mirrored = FrameSpec(image_mirrored=True, contact_side="head", thread="right")
    assert mirrored.tightens(CW) is False


def test_the_missing_facts_are_named():
    assert FrameSpec().missing_for_thread() == ("contact_side", "thread")
    assert FrameSpec(thread="left").missing_for_thread() == ("contact_side",)


def test_every_frame_has_its_own_sentence_and_survives_json():
    sentences = {
        json.loads(json.dumps(FrameSpec(*frame).to_dict()))["sentence"] for frame in FRAMES
    }
    assert len(sentences) == len(FRAMES)


def test_a_pixel_of_a_size_no_camera_has_is_refused_with_how_to_find_its_own():
    with pytest.raises(UsageError) as caught:
        FrameSpec(mm_per_px=9.0)
    assert str(caught.value) == (
        "A pixel of 9 mm was given, expected 0.001 to 2 mm, such as 0.06 of a GelSight Mini's "
        "320x240; divide the mm of gel that are seen by the image's columns."
    )


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("image_mirrored", "no", "True or False"),
        ("image_mirrored", 1, "True or False"),
        ("image_mirrored", None, "True or False"),
        ("viewpoint", "Object", "'sensor' or 'object'"),
        ("viewpoint", True, "'sensor' or 'object'"),
        ("viewpoint", ["object"], "'sensor' or 'object'"),
        ("actor", "robot", "'object' or 'sensor'"),
        ("actor", None, "'object' or 'sensor'"),
        ("contact_side", "top", "'head', 'shank', 'side' or None"),
        ("contact_side", "", "'head', 'shank', 'side' or None"),
        ("thread", "right-hand", "'right', 'left' or None"),
        ("thread", np.zeros(2), "'right', 'left' or None"),
        ("image_upside_down", "yes", "True or False"),
    ],
)
def test_a_field_that_is_none_of_its_values_is_refused_with_those_that_are(field, value, expected):
    with pytest.raises(UsageError) as caught:
        FrameSpec(**{field: value})
    assert str(caught.value) == (
        f"{field} was {value!r}, expected {expected}; give one of these as it is written here, or "
        f"leave {field} out."
    )


@pytest.mark.parametrize("value", ["0.06", True, [0.06], 1j])
def test_a_size_that_is_no_number_is_refused(value):
    with pytest.raises(UsageError) as caught:
        FrameSpec(mm_per_px=value)
    assert str(caught.value) == (
        f"mm_per_px was {value!r}, expected a number from 0.001 to 2 or None; give the millimetres "
        f"of gel that a pixel is wide, or leave mm_per_px out."
    )


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -0.06, 0])
def test_a_size_that_is_none_of_a_pixel_is_refused(value):
    with pytest.raises(UsageError, match=r"^A pixel of \S+ mm was given, expected 0.001 to 2 mm,"):
        FrameSpec(mm_per_px=value)


def test_any_number_is_a_size():
    for value in (1, np.float32(0.06), np.float64(0.06)):
        assert FrameSpec(mm_per_px=value).mm_per_px == value
