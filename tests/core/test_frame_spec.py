"""How a motion reads from another frame of reference, and when a thread tightens."""

import json

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion

CW, CCW = Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE
FRAMES = [
    FrameSpec(mirrored, view, actor, **FrameSpec.fields_of_turn(degrees))
    for mirrored in (False, True)
    for view in ("sensor", "object")
    for actor in ("object", "sensor")
    for degrees in (0, 90, 180, 270)
]


@pytest.mark.parametrize(
    ("degrees", "fields"),
    [
        (0, (False, None)),
        (90, (False, "clockwise")),
        (180, (True, None)),
        (270, (False, "counterclockwise")),
        (-90, (False, "counterclockwise")),
        (450, (False, "clockwise")),
    ],
)
def test_turns_by_whole_quarters_add_up(degrees, fields):
    names = ("image_upside_down", "image_quarter_turn")
    assert FrameSpec.fields_of_turn(degrees) == dict(zip(names, fields, strict=True))


@pytest.mark.parametrize(
    ("side", "thread", "motion"),
    [
        ("side", "right", CW),
        (None, "right", CW),
        ("head", None, CW),
        ("head", "right", Motion.LEFT),
    ],
)
def test_without_a_turn_or_a_fact_nothing_tightens(side, thread, motion):
    assert FrameSpec(contact_side=side, thread=thread).tightens(motion) is None


def test_a_mirrored_image_inverts_tightening():
    mirrored = FrameSpec(image_mirrored=True, contact_side="head", thread="right")
    assert mirrored.tightens(CW) is False


def test_the_missing_facts_are_named():
    assert FrameSpec().missing_for_thread() == ("contact_side", "thread")
    assert FrameSpec(thread="left").missing_for_thread() == ("contact_side",)


def test_every_frame_has_its_own_sentence_and_survives_json():
    sentences = {json.loads(json.dumps(frame.to_dict()))["sentence"] for frame in FRAMES}
    assert len(sentences) == len(FRAMES)


def test_the_sentence_says_which_way_a_turned_image_is_turned_back():
    frame = FrameSpec(image_mirrored=True, image_quarter_turn="clockwise")
    assert frame.sentence() == (
        "camera image turned back by 90 degrees counterclockwise with the mirror undone, looking "
        "out of the sensor, object relative to sensor"
    )


@pytest.mark.parametrize("value", [9.0, float("nan"), float("inf"), -0.06, 0])
def test_a_pixel_of_a_size_no_camera_has_is_refused_with_how_to_find_its_own(value):
    with pytest.raises(UsageError) as caught:
        FrameSpec(mm_per_px=value)
    assert str(caught.value) == (
        f"A pixel of {value:g} mm was given, expected 0.001 to 2 mm, such as 0.06 of a GelSight "
        "Mini's 320x240; divide the mm of gel that are seen by the image's columns."
    )


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("image_mirrored", "no", "True or False"),
        ("viewpoint", "Object", "'sensor' or 'object'"),
        ("viewpoint", ["object"], "'sensor' or 'object'"),
        ("actor", "robot", "'object' or 'sensor'"),
        ("contact_side", "top", "'head', 'shank', 'side' or None"),
        ("thread", np.zeros(2), "'right', 'left' or None"),
        ("image_quarter_turn", 90, "'clockwise', 'counterclockwise' or None"),
    ],
)
def test_a_field_that_is_none_of_its_values_is_refused_with_those_that_are(field, value, expected):
    with pytest.raises(UsageError) as caught:
        FrameSpec(**{field: value})
    assert str(caught.value) == (
        f"{field} was {value!r}, expected {expected}; give one of these as it is written here, or "
        f"leave {field} out."
    )
