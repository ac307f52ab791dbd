"""What follows from a motion and a frame: the laws of `FrameSpec`, in words."""

import itertools
from dataclasses import replace

import pytest

from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.motion_answers import CAMERA, RuleInput, answer_from_motion
from geotlm_lm.conversation.wording import direction_clause
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, reverse

CW = Motion.CLOCKWISE
FRAMES = [
    FrameSpec(*fields)
    for fields in itertools.product((False, True), ("sensor", "object"), ("object", "sensor"))
]
FRAMES += [
    replace(frame, image_quarter_turn=turn)
    for frame in FRAMES
    for turn in ("clockwise", "counterclockwise")
]
OBJECT_SIDE = FrameSpec(viewpoint="object")
SCREW = FrameSpec(thread="right", contact_side="head")


def felt(kind, motion=CW, frame=CAMERA, question="", share=0.9, verdict=None):
    """The motion with `share`, its opposite with half of the rest."""
    ways = {motion: share, reverse(motion): (1 - share) / 2}
    return answer_from_motion(RuleInput(kind, Felt(ways, 1.0), question, frame, verdict, motion))


@pytest.mark.parametrize("motion", DIRECTED)
@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_a_direction_names_its_frame_once(motion, frame):
    text = direction_clause(motion, frame)
    assert text.count("camera image") + text.count("object's side") == 1


def test_the_chance_that_it_tightens_is_that_of_the_turn():
    assert felt("thread", CW, SCREW, share=0.8).options == pytest.approx(
        {"tightens": 0.8, "loosens": 0.1}
    )


def test_a_claim_in_unknown_words_is_the_one_the_model_found_true():
    told = felt("verify", CW, OBJECT_SIDE, "righty tighty?", verdict=True)
    assert told.text == "Yes, it turns counterclockwise seen from the object's side."


def test_a_claim_nobody_understood_gets_the_direction_and_no_verdict():
    told = felt("verify", CW, OBJECT_SIDE, "righty tighty?", verdict=False)
    assert told.text == "It turns counterclockwise seen from the object's side."


def test_letters_of_one_motion_are_one_answer():
    told = felt("choice", CW, OBJECT_SIDE, "A) left B) counterclockwise C) anticlockwise")
    assert told.decided == "B) counterclockwise"
    assert list(told.options) == ["A) left", "B) counterclockwise"]
    assert sum(told.options.values()) == pytest.approx(1)


def test_a_choice_without_the_motion_gets_the_direction_alone():
    told = felt("choice", CW, OBJECT_SIDE, "A) up B) left")
    assert told.text == (
        "It does not slide; it turns counterclockwise seen from the object's side."
    )
