"""Which way a half goes: the law of a turn, and the questions about one half."""

import pytest

from geotlm_lm.conversation.half_ways import asked_half, claimed_half, way_of
from geotlm_lm.conversation.retell import CAMERA, Felt, retell
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import SLIDES, Motion, mirror, reverse, turn_by_quarter

CW, CCW, LEFT, RIGHT, UP, DOWN = (
    Motion.CLOCKWISE,
    Motion.COUNTERCLOCKWISE,
    Motion.LEFT,
    Motion.RIGHT,
    Motion.UP,
    Motion.DOWN,
)
HALVES = ("upper", "right", "lower", "left")


def test_a_clockwise_turn_carries_the_upper_half_to_the_right_and_so_on_round():
    assert [way_of(half, CW) for half in HALVES] == [RIGHT, DOWN, LEFT, UP]


@pytest.mark.parametrize("half", HALVES)
def test_opposite_halves_and_opposite_turns_go_opposite_ways(half):
    across = HALVES[(HALVES.index(half) + 2) % 4]
    assert way_of(half, CW) == reverse(way_of(half, CCW)) == reverse(way_of(across, CW))


@pytest.mark.parametrize("half", HALVES)
def test_a_turn_of_the_image_turns_halves_and_ways_alike(half):
    turned = HALVES[HALVES.index(half) - 1]
    assert way_of(turned, CW) == turn_by_quarter(way_of(half, CW))
    if half in ("upper", "lower"):
        assert way_of(half, mirror(CW)) == mirror(way_of(half, CW))


@pytest.mark.parametrize("motion", SLIDES)
def test_all_halves_go_the_way_of_a_slide(motion):
    assert {way_of(half, motion) for half in HALVES} == {motion}


@pytest.mark.parametrize(
    ("question", "half"),
    [
        ("Which way does the top edge move?", "upper"),
        ("Which way does the left side of the imprint move?", "left"),
        ("where does the bottom of the contact go?", "lower"),
        ("Which direction is the right edge moving", "right"),
        ("Which way does it move?", None),
        ("Which way does the right cap move?", None),
        ("Which way does the top turn?", None),
        ("Which way does the left side of the video move?", None),
        ("Which way does the top of the page face?", None),
    ],
)
def test_a_half_is_asked_for(question, half):
    assert asked_half(question) == half


@pytest.mark.parametrize(
    ("question", "half", "way"),
    [
        ("Does the top go right?", "upper", RIGHT),
        ("Is the top moving to the right?", "upper", RIGHT),
        ("Does the bottom go left?", "lower", LEFT),
        ("is the left edge going up?", "left", UP),
        ("Did the right side of the cap shift downwards", "right", DOWN),
    ],
)
def test_a_half_is_claimed_to_go_one_way(question, half, way):
    claim = claimed_half(question)
    assert (claim.half, claim.way) == (half, way)


@pytest.mark.parametrize(
    "question",
    [
        "Does the left cap go right?",
        "Does the top turn clockwise?",
        "Is the top moving?",
        "Does it go to the top?",
        "Does the object at the top go right?",
        "Which half goes right?",
        "Does the top go left or right?",
    ],
)
def test_no_half_is_claimed_elsewhere(question):
    assert claimed_half(question) is None


def told(motion, kind, question, frame=CAMERA):
    return retell(Felt(kind, motion, question, frame, {motion: 0.9, Motion.NONE: 0.1}))


@pytest.mark.parametrize(
    ("motion", "text", "decided"),
    [
        (CW, "Yes, the upper half goes right: it goes clockwise in the camera image.", "yes"),
        (CCW, "No, the upper half goes left: it goes counterclockwise in the camera image.", "no"),
        (RIGHT, "Yes, the upper half goes right: it goes right in the camera image.", "yes"),
        (UP, "No, the upper half goes up: it goes up in the camera image.", "no"),
        (Motion.PRESS, "No, it is pressing in.", "no"),
    ],
)
def test_a_claim_about_a_half_is_judged_by_where_it_goes(motion, text, decided):
    answer = told(motion, "verify", "Does the top go right?")
    assert (answer.text, answer.decided) == (text, decided)


@pytest.mark.parametrize(
    ("motion", "frame", "text"),
    [
        (CW, CAMERA, "The left half goes up, in the camera image."),
        (LEFT, CAMERA, "The left half goes left, in the camera image."),
        (
            CW,
            FrameSpec(viewpoint="object"),
            "The left half goes down, seen from the object's side.",
        ),
        (Motion.STILL, CAMERA, "It is still: touching but not moving."),
    ],
)
def test_the_way_of_a_half_is_told_in_the_frame(motion, frame, text):
    answer = told(motion, "direction", "Which way does the left side move?", frame)
    assert (answer.text, answer.direction) == (text, frame.tell(motion))
    assert answer.options[answer.decided] == pytest.approx(0.9)
