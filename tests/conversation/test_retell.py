"""What follows from a motion and a frame: the laws of `FrameSpec`, in words."""

import itertools
from dataclasses import replace

import pytest

from geotlm_lm.conversation.retell import CAMERA, Felt, retell
from geotlm_lm.conversation.wording import AT_REST, clause, sentence
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, mirror, reverse

CW, CCW, LEFT, RIGHT, UP = (
    Motion.CLOCKWISE,
    Motion.COUNTERCLOCKWISE,
    Motion.LEFT,
    Motion.RIGHT,
    Motion.UP,
)
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
    """The motion with `share`, its opposite with most of the rest."""
    rest = (1 - share) / 2
    shares = {motion: share, reverse(motion): rest, Motion.NONE: rest}
    if len(shares) < 3:
        shares = {motion: share, Motion.LEFT: 1 - share}
    return retell(Felt(kind, motion, question, frame, shares, verdict))


@pytest.mark.parametrize("frame", FRAMES, ids=str)
@pytest.mark.parametrize("motion", Motion)
def test_every_kind_tells_its_exact_function_of_the_motion(motion, frame):
    def direction(kind):
        return felt(kind, motion, frame).direction

    assert direction("direction") == frame.tell(motion)
    assert direction("mirrored") == frame.tell(mirror(motion))
    assert direction("reversed") == frame.tell(reverse(motion))
    assert direction("undo") == frame.tell(reverse(motion))
    assert direction("viewpoint") == replace(frame, viewpoint="object").tell(motion)
    assert direction("actor") == replace(frame, actor="sensor").tell(motion)


@pytest.mark.parametrize(
    ("kind", "motion", "frame", "text"),
    [
        ("direction", CW, OBJECT_SIDE, "Counterclockwise, seen from the object's side."),
        (
            "direction",
            LEFT,
            FrameSpec(image_mirrored=True),
            "Right, in the camera image with the mirror undone.",
        ),
        (
            "direction",
            LEFT,
            FrameSpec(image_upside_down=True),
            "Right, in the camera image turned by 180 degrees.",
        ),
        (
            "direction",
            UP,
            FrameSpec(image_mirrored=True, image_upside_down=True),
            "Down, in the camera image with the mirror undone and the image turned by 180 degrees.",
        ),
        (
            "direction",
            UP,
            FrameSpec(viewpoint="object", image_upside_down=True),
            "Down, seen from the object's side with the image turned by 180 degrees.",
        ),
        (
            "direction",
            LEFT,
            FrameSpec(image_quarter_turn="clockwise"),
            "Down, in the camera image turned back by 90 degrees counterclockwise.",
        ),
        (
            "direction",
            LEFT,
            FrameSpec(image_mirrored=True, image_quarter_turn="counterclockwise"),
            "Up, in the camera image with the image turned back by 90 degrees clockwise and the "
            "mirror undone.",
        ),
        (
            "direction",
            UP,
            FrameSpec(image_mirrored=True, image_quarter_turn="counterclockwise"),
            "Left, in the camera image with the image turned back by 90 degrees clockwise and the "
            "mirror undone.",
        ),
        (
            "direction",
            UP,
            FrameSpec(viewpoint="object", image_quarter_turn="clockwise"),
            "Right, seen from the object's side with the image turned back by 90 degrees "
            "counterclockwise.",
        ),
        (
            "direction",
            CW,
            FrameSpec(image_quarter_turn="clockwise"),
            "Clockwise, in the camera image turned back by 90 degrees counterclockwise.",
        ),
        (
            "actor",
            LEFT,
            FrameSpec(image_quarter_turn="clockwise"),
            "The sensor goes up, in the camera image turned back by 90 degrees counterclockwise.",
        ),
        (
            "undo",
            LEFT,
            FrameSpec(image_quarter_turn="clockwise"),
            "Moving up undoes it, in the camera image turned back by 90 degrees counterclockwise.",
        ),
        ("direction", UP, FrameSpec(actor="sensor"), "The sensor goes down, in the camera image."),
        ("direction", Motion.PRESS, OBJECT_SIDE, "It is pressing in."),
        ("viewpoint", CW, CAMERA, "Counterclockwise, seen from the object's side."),
        ("actor", LEFT, CAMERA, "The sensor goes right, in the camera image."),
        ("mirrored", CCW, CAMERA, "Clockwise, in the camera image, if the clip is mirrored."),
        ("mirrored", UP, CAMERA, "Up, in the camera image, if the clip is mirrored."),
        ("reversed", UP, CAMERA, "Down, in the camera image, played backwards."),
        ("reversed", Motion.PRESS, CAMERA, "It is lifting off, played backwards."),
        ("undo", CW, CAMERA, "Moving counterclockwise undoes it, in the camera image."),
        ("undo", Motion.PRESS, CAMERA, "Lifting off undoes it."),
        (
            "undo",
            Motion.STILL,
            CAMERA,
            "There is nothing to undo: it is touching but not moving.",
        ),
        (
            "confidence",
            CW,
            CAMERA,
            "My confidence is high: 90% that it goes clockwise in the camera image.",
        ),
        (
            "thread",
            CW,
            SCREW,
            "It tightens: clockwise in the camera image, right-hand thread touched at its head.",
        ),
        (
            "thread",
            CW,
            replace(SCREW, thread="left"),
            "It loosens: clockwise in the camera image, left-hand thread touched at its head.",
        ),
        (
            "thread",
            CW,
            CAMERA,
            "I cannot tell tightening from loosening: tell me which side touches the gel (head, "
            "shank or side) and whether the thread is right-hand or left-hand.",
        ),
        (
            "thread",
            CW,
            FrameSpec(thread="left"),
            "I cannot tell tightening from loosening: tell me which side touches the gel (head, "
            "shank or side).",
        ),
        (
            "thread",
            LEFT,
            FrameSpec(contact_side="side"),
            "I cannot tell tightening from loosening: gripped at its side, a turn shows as a "
            "slide.",
        ),
        ("thread", LEFT, CAMERA, "Neither tighter nor looser: it goes left in the camera image."),
        (
            "thread",
            CW,
            replace(SCREW, actor="sensor"),
            "Neither tighter nor looser: the sensor moved, not the object.",
        ),
    ],
)
def test_answers_read_as_written_here(kind, motion, frame, text):
    assert felt(kind, motion, frame).text == text


@pytest.mark.parametrize("motion", DIRECTED)
@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_a_direction_names_its_frame_once(motion, frame):
    for text in (sentence(motion, frame), clause(motion, frame)):
        assert text.count("camera image") + text.count("object's side") == 1


@pytest.mark.parametrize(
    ("question", "frame", "direction"),
    [
        ("What would tighten it?", SCREW, CW),
        ("Which way must I turn to loosen it?", SCREW, CCW),
        ("how do I unscrew it?", replace(SCREW, thread="left"), CW),
        ("What would tighten it?", replace(SCREW, viewpoint="object"), CCW),
    ],
)
def test_what_would_tighten_needs_no_motion_but_the_facts(question, frame, direction):
    told = felt("thread", Motion.STILL, frame, question)
    assert told.direction == direction
    assert felt("thread", LEFT, CAMERA, question).is_refusal


def test_the_chance_that_it_tightens_is_that_of_the_turn():
    assert felt("thread", CW, SCREW, share=0.8).options == pytest.approx(
        {"tightens": 0.8, "loosens": 0.1}
    )


@pytest.mark.parametrize(
    ("kind", "question", "frame", "text", "share"),
    [
        ("negation", "It isn't clockwise, is it?", CAMERA, "It is: {}.", 0.9),
        ("negation", "Is it not going left?", CAMERA, "It is not: {}.", 1.0),
        # What turns left turns counterclockwise.
        ("negation", "Is it not turning left?", CAMERA, "It is not: {}.", 0.95),
        ("verify", "Is it turning to the right?", CAMERA, "Yes, {}.", 0.9),
        ("verify", "Is it moving horizontally?", CAMERA, "No, {}.", 1.0),
        ("premise", "How fast is it turning clockwise?", CAMERA, "That holds: {}.", 0.9),
        ("premise", "How fast is it sliding up?", CAMERA, "But no, {}.", 1.0),
        ("verify", "Is it turning clockwise?", OBJECT_SIDE, "No, {}.", 0.95),
        ("verify", "Is it turning counterclockwise?", OBJECT_SIDE, "Yes, {}.", 0.9),
    ],
)
def test_a_claim_is_judged_in_the_frame_of_the_question(kind, question, frame, text, share):
    told = felt(kind, CW, frame, question)
    assert told.text == text.format(clause(frame.tell(CW), frame))
    assert told.options[told.decided] == pytest.approx(share)
    assert sum(told.options.values()) == pytest.approx(1.0)


def test_a_claim_in_unknown_words_is_the_one_the_model_found_true():
    told = felt("verify", CW, OBJECT_SIDE, "righty tighty?", verdict=True)
    assert told.text == "No, it goes counterclockwise seen from the object's side."


def test_a_claim_nobody_understood_gets_the_direction_and_no_verdict():
    told = felt("verify", CW, OBJECT_SIDE, "righty tighty?", verdict=False)
    assert told.text == "Counterclockwise, seen from the object's side."


def test_a_choice_picks_the_letter_of_the_motion_as_the_frame_tells_it():
    told = felt("choice", CW, OBJECT_SIDE, "A) clockwise B) left C) counterclockwise")
    assert told.text == "Counterclockwise, seen from the object's side, option C."
    assert told.options["C) counterclockwise"] == pytest.approx(0.9 / 0.95)


def test_letters_of_one_motion_are_one_answer():
    told = felt("choice", CW, OBJECT_SIDE, "A) left B) counterclockwise C) anticlockwise")
    assert told.decided == "B) counterclockwise"
    assert list(told.options) == ["A) left", "B) counterclockwise"]
    assert sum(told.options.values()) == pytest.approx(1)


def test_a_choice_without_the_motion_gets_the_direction_alone():
    told = felt("choice", CW, OBJECT_SIDE, "A) up B) left")
    assert told.text == "Counterclockwise, seen from the object's side."


@pytest.mark.parametrize("kind", ["direction", "viewpoint", "mirrored", "reversed", "undo"])
def test_a_change_of_frame_keeps_the_probability(kind):
    told = felt(kind, UP, share=0.7)
    assert told.options[told.decided] == pytest.approx(0.7)


def test_rest_is_told_in_the_words_of_the_templates():
    from geotlm_lm.data.templates import load_templates
    from geotlm_lm.language.parse_answer import Slots

    grammar = load_templates().grammar()
    for motion, text in AT_REST.items():
        assert grammar.parse(text) == Slots("direction", motion)
    for motion in DIRECTED:
        assert grammar.parse(sentence(motion, CAMERA)) == Slots("direction", motion)


@pytest.mark.parametrize(
    ("question", "asks_how"),
    [
        ("Which direction tightens it?", True),
        ("Which way loosens the lid?", True),
        ("What turn unscrews it?", True),
        ("Which way do I turn it to loosen it?", True),
        ("How do you tighten it?", True),
        ("What is happening to the lid, is it loosening?", False),
        ("What happens to it, does it tighten?", False),
        ("Which of the lids is loosening?", False),
    ],
)
def test_what_would_tighten_is_told_from_what_tightens_now(question, asks_how):
    told = felt("thread", LEFT, SCREW, question)
    assert (told.decided != "neither") is asks_how
