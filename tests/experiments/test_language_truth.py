"""The truth of every question type against the product's own path: a model that says what is right
is graded right, one that feels another motion is graded wrong. Truths come from labels alone.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geotlm_lm.answering import OPEN_QUESTION, Answerer
from geotlm_lm.conversation.short_questions import in_full
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel, mirror, reverse
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.experiments.language_truth import (
    Truth,
    claim_of,
    is_right,
    letters_of,
    scored_is_right,
    truth_of,
)
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, first_kinds_of, recording
from tests.tiny_bundle import tiny_bundle

CAMERA = FrameSpec()
TYPES = tuple(load_templates().types)
AMOUNTS = ("T7", "T8")
BY_GEOMETRY = "T10"
LABELS = {
    motion: MotionLabel(
        motion,
        rotation_deg={Motion.CLOCKWISE: 20.0, Motion.COUNTERCLOCKWISE: -20.0}.get(motion, 0.0),
        slide_x_mm={Motion.LEFT: -1.0, Motion.RIGHT: 1.0}.get(motion, 0.0),
        slide_y_mm={Motion.UP: -1.0, Motion.DOWN: 1.0}.get(motion, 0.0),
        mm_per_px=(0.1, 0.1),
    )
    for motion in Motion
}


@pytest.fixture(scope="module")
def bundle():
    return tiny_bundle()


def asked_about(motion, type_id, seed=0, wordings="seen"):
    rng = np.random.default_rng(seed)
    return questions_for(LABELS[motion], rng, types=[type_id], wordings=wordings)[0]


def answer_of(bundle, asked, felt, frame=CAMERA, *, knows_all=True, says=None):
    """What the product answers when the model feels `felt`, and says what is right of that."""
    opened = bundle.grammar.sentence(Slots("direction", Motion(felt)))
    grammar = bundle.grammar if knows_all else first_kinds_of(bundle.grammar)
    # A claim of a word or two is put to the model as a whole question.
    said = dict.fromkeys((asked.question, in_full(asked.question)), says or asked.answer)
    sentences = said | {OPEN_QUESTION: opened, "*": opened}
    # Sure of its words even among the forty answers to a choice: doubt is not the matter here.
    measures = {"deg": 20.0, "px": 10.0}
    return answerer_saying(
        bundle, sentences, grammar=grammar, measures=measures, temperature=0.2
    ).ask(perceived(bundle), asked.question, frame=frame)


@cache
def perceived(bundle):
    return Answerer(bundle).encode(recording(fps=25.0, size=(224, 224)))


@pytest.mark.parametrize("motion", Motion)
@pytest.mark.parametrize("type_id", TYPES)
@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_a_model_that_knows_every_kind_and_says_what_is_right_is_right(
    bundle, type_id, motion, wordings
):
    asked = asked_about(motion, type_id, seed=4, wordings=wordings)
    answer = answer_of(bundle, asked, motion)
    assert is_right(asked, answer, truth_of(asked, motion, CAMERA)), (asked.question, answer.text)


@pytest.mark.parametrize("motion", Motion)
@pytest.mark.parametrize("type_id", sorted({*TYPES} - {*AMOUNTS, BY_GEOMETRY}))
def test_a_model_of_the_first_kinds_is_right_by_rule(bundle, type_id, motion):
    asked = asked_about(motion, type_id, seed=5)
    answer = answer_of(bundle, asked, motion, knows_all=False)
    assert is_right(asked, answer, truth_of(asked, motion, CAMERA)), (asked.question, answer.text)


@pytest.mark.parametrize(
    "type_id", ["T1", "T2", "T3", "T4", "T11", "T12", "T14", "T15", "T18", "T19", "T21"]
)
@pytest.mark.parametrize("knows_all", [True, False])
def test_a_model_that_feels_the_opposite_is_wrong(bundle, type_id, knows_all):
    asked = asked_about(Motion.LEFT, type_id, seed=6)
    kind = load_templates().types[type_id]
    says = (
        next(
            sentence
            for sentence, slots in kind.answers.items()
            if slots.direction in (Motion.RIGHT, None) and sentence != asked.answer
        )
        if len(kind.answers) > 1
        else None
    )
    answer = answer_of(bundle, asked, Motion.RIGHT, knows_all=knows_all, says=says)
    assert not is_right(asked, answer, truth_of(asked, Motion.LEFT, CAMERA))


@pytest.mark.parametrize("motion", [Motion.CLOCKWISE, Motion.UP, Motion.PRESS, Motion.STILL])
@pytest.mark.parametrize("side", ["head", "shank", "side", None])
@pytest.mark.parametrize("thread", ["right", "left", None])
def test_a_thread_is_told_as_its_facts_allow(bundle, motion, side, thread):
    frame = FrameSpec(contact_side=side, thread=thread)
    asked = asked_about(motion, "T13", seed=7)
    answer = answer_of(bundle, asked, motion, frame, knows_all=False)
    assert is_right(asked, answer, truth_of(asked, motion, frame)), (asked.question, answer.text)


def test_a_right_hand_thread_at_its_head_tightens_clockwise():
    asked = asked_about(Motion.CLOCKWISE, "T13")
    frame = FrameSpec(contact_side="head", thread="right")
    assert truth_of(asked, Motion.CLOCKWISE, frame).decided == "tightens"
    assert truth_of(asked, Motion.CLOCKWISE, replace(frame, thread="left")).decided == "loosens"
    assert truth_of(asked, Motion.CLOCKWISE, replace(frame, thread=None)).abstains


@pytest.mark.parametrize(
    ("type_id", "told"),
    [
        ("T11", Motion.COUNTERCLOCKWISE),
        ("T12", Motion.COUNTERCLOCKWISE),
        ("T14", Motion.COUNTERCLOCKWISE),
        ("T15", Motion.COUNTERCLOCKWISE),
        ("T21", Motion.COUNTERCLOCKWISE),
        ("T1", Motion.CLOCKWISE),
        ("T19", Motion.CLOCKWISE),
    ],
)
def test_a_clockwise_turn_is_told_as_the_question_wants_it(type_id, told):
    asked = asked_about(Motion.CLOCKWISE, type_id)
    assert truth_of(asked, Motion.CLOCKWISE, CAMERA) == Truth(told.value, told)


def test_speed_without_a_time_is_rightly_declined():
    asked = asked_about(Motion.LEFT, "T8")
    assert truth_of(asked, Motion.LEFT, CAMERA, is_timed=False).abstains
    assert not truth_of(asked, Motion.LEFT, CAMERA).abstains


@pytest.mark.parametrize(("said", "right"), [(23, True), (27, False), (18, True), (15, False)])
def test_an_amount_is_right_within_a_fifth(bundle, said, right):
    asked = asked_about(Motion.CLOCKWISE, "T7")  # 20 degrees
    answer = replace(answer_of(bundle, asked, Motion.CLOCKWISE), decided=f"{said} deg")
    assert is_right(asked, answer, truth_of(asked, Motion.CLOCKWISE, CAMERA)) == right


def test_an_amount_in_the_other_unit_is_wrong(bundle):
    asked = asked_about(Motion.CLOCKWISE, "T7")
    answer = replace(answer_of(bundle, asked, Motion.CLOCKWISE), decided="20 px")
    assert not is_right(asked, answer, truth_of(asked, Motion.CLOCKWISE, CAMERA))


def test_words_that_do_not_parse_are_wrong(bundle):
    asked = asked_about(Motion.LEFT, "T1")
    answer = answer_of(bundle, asked, Motion.LEFT, says="Left, I suppose.")
    assert not is_right(asked, answer, truth_of(asked, Motion.LEFT, CAMERA))


def test_the_scored_answer_may_be_right_where_the_words_are_not(bundle):
    asked = asked_about(Motion.LEFT, "T1")
    truth = truth_of(asked, Motion.LEFT, CAMERA)
    answer = answer_of(bundle, asked, Motion.LEFT, says="Left, I suppose.")
    knows = replace(answer, options={"left": 0.6, "right": 0.4})
    assert scored_is_right(knows, truth) is True
    assert scored_is_right(replace(answer, options={"left": 0.4, "right": 0.6}), truth) is False
    assert scored_is_right(replace(answer, options={}), truth) is None


def test_a_question_in_another_frame_is_held_to_that_frame():
    asked = asked_about(Motion.LEFT, "T2", seed=1)
    mirrored = FrameSpec(image_mirrored=True)
    claims_right = claim_of(asked) == Motion.RIGHT
    truth = truth_of(asked, Motion.LEFT, mirrored)
    assert truth == Truth("yes" if claims_right else "no", Motion.RIGHT)


def test_every_offered_motion_has_its_letter():
    asked = asked_about(Motion.UP, "T3")
    letters = letters_of(asked)
    assert letters[Motion.UP] == asked.slots.letter
    assert sorted(letters.values()) == list("ABCD"[: len(letters)])


@pytest.mark.parametrize(
    "frame",
    [
        CAMERA,
        FrameSpec(image_mirrored=True),
        FrameSpec(viewpoint="object", actor="sensor"),
        FrameSpec(image_quarter_turn="clockwise"),
    ],
    ids=str,
)
@pytest.mark.parametrize("motion", DIRECTED)
def test_a_changed_clip_is_told_as_an_open_question_of_the_changed_motion_is(motion, frame):
    types = {kind.kind: type_id for type_id, kind in load_templates().types.items()}

    def truth(kind, of):
        return truth_of(asked_about(motion, types[kind], seed=1), of, frame)

    assert truth("reversed", motion) == truth("undo", motion) == truth("direction", reverse(motion))
    assert truth("mirrored", motion) == truth("direction", mirror(motion))
