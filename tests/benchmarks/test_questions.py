"""Truths come from labels alone: a model that says what is right is graded right, one that feels
another motion is graded wrong; rows and calibration are counted by hand.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from geotlm_lm.conversation.short_questions import expanded_question

from geotlm_lm.answering import OPEN_QUESTION, Answerer
from geotlm_lm.benchmarks.question_truths import is_right
from geotlm_lm.benchmarks.question_truths import truth_of as truth_of_question
from geotlm_lm.benchmarks.questions import (
    QUESTIONS,
    WORDS,
    Asked,
    calibration,
    question_rows,
    type_rows,
)
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel, mirror, reverse
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, believed, feeling, first_kinds_of, recording
from tests.tiny_bundle import tiny_bundle

CAMERA = FrameSpec()
TYPES = tuple(load_templates().types)
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


def truth_of(asked, motion, frame=CAMERA, **more):
    return truth_of_question(asked, motion, frame, **more)


def asked_about(motion, type_id, seed=0, wordings="seen"):
    rng = np.random.default_rng(seed)
    return questions_for(LABELS[motion], rng, types=[type_id], wordings=wordings)[0]


def answer_of(bundle, asked, felt, frame=CAMERA, *, knows_all=True, says=None):
    """What the product answers when the model feels `felt`, and says what is right of that."""
    opened = bundle.grammar.sentence(Slots("direction", Motion(felt)))
    grammar = bundle.grammar if knows_all else first_kinds_of(bundle.grammar)
    # A claim of a word or two is put to the model as a whole question.
    said = dict.fromkeys((asked.question, expanded_question(asked.question)), says or asked.answer)
    sentences = said | {OPEN_QUESTION: opened, "*": opened}
    belief = believed(felt, deg=20.0, px=10.0)
    answerer = answerer_saying(bundle, sentences, grammar=grammar, belief=belief)
    return answerer.ask(perceived(bundle), asked.question, frame=frame)


@cache
def perceived(bundle):
    return Answerer(bundle).encode(recording(fps=25.0, size=(224, 224)))


@pytest.mark.parametrize("motion", Motion)
@pytest.mark.parametrize("type_id", TYPES)
def test_a_model_that_knows_every_kind_and_says_what_is_right_is_right(bundle, type_id, motion):
    asked = asked_about(motion, type_id, seed=4)
    answer = answer_of(bundle, asked, motion)
    assert is_right(asked, answer, truth_of(asked, motion), motion), (asked.question, answer.text)


@pytest.mark.parametrize("type_id", sorted({*TYPES} - {"T7", "T8", "T10"}))
def test_a_model_of_the_first_kinds_is_right_by_rule(bundle, type_id):
    asked = asked_about(Motion.UP, type_id, seed=5)
    answer = answer_of(bundle, asked, Motion.UP, knows_all=False)
    truth = truth_of(asked, Motion.UP)
    assert is_right(asked, answer, truth, Motion.UP), (asked.question, answer.text)


@pytest.mark.parametrize(
    "type_id", ["T1", "T2", "T3", "T4", "T11", "T12", "T14", "T15", "T18", "T19", "T21"]
)
def test_a_model_that_feels_the_opposite_is_wrong(bundle, type_id):
    asked = asked_about(Motion.LEFT, type_id, seed=6)
    answers = load_templates().types[type_id].answers
    others = (
        sentence
        for sentence, slots in answers.items()
        if slots.direction in (Motion.RIGHT, None) and sentence != asked.answer
    )
    says = next(others, None)
    answer = answer_of(bundle, asked, Motion.RIGHT, says=says)
    assert not is_right(asked, answer, truth_of(asked, Motion.LEFT), Motion.LEFT)


@pytest.mark.parametrize(
    ("motion", "is_it"),
    [(Motion.CLOCKWISE, True), (Motion.COUNTERCLOCKWISE, False), (Motion.STILL, None)],
)
def test_evidence_by_rule_is_right_where_it_goes_the_way_of_the_motion(bundle, motion, is_it):
    asked = asked_about(motion, "T10")
    answer = answer_of(bundle, asked, motion, knows_all=False)
    still = {"shear_change_x": 0.0, "shear_change_y": 0.0}
    regions = dict.fromkeys(answer.evidence["regions"], still)
    regions["upper_minus_lower"] = {"shear_change_x": 1.0, "shear_change_y": 0.0}
    regions["left_minus_right"] = {"shear_change_x": 0.0, "shear_change_y": -1.0}
    evidence = dict(answer.evidence) | {"regions": regions}
    told = replace(answer, evidence=evidence, kind="evidence", told_by="rule", abstained=False)
    assert is_right(asked, told, truth_of(asked, motion), motion) is is_it


def test_a_right_hand_thread_at_its_head_tightens_clockwise():
    asked = asked_about(Motion.CLOCKWISE, "T13")
    frame = FrameSpec(contact_side="head", thread="right")
    assert truth_of(asked, Motion.CLOCKWISE, frame).decided == "tightens"
    assert truth_of(asked, Motion.CLOCKWISE, replace(frame, thread="left")).decided == "loosens"
    assert truth_of(asked, Motion.CLOCKWISE, replace(frame, thread=None)).abstains


@pytest.mark.parametrize(
    ("said", "right"), [("23 deg", True), ("27 deg", False), ("15 deg", False), ("20 px", False)]
)
def test_an_amount_is_right_within_a_fifth_and_in_its_unit(bundle, said, right):
    motion = Motion.CLOCKWISE
    asked = asked_about(motion, "T7")  # 20 degrees
    answer = replace(answer_of(bundle, asked, motion), decided=said)
    assert is_right(asked, answer, truth_of(asked, motion), motion) == right


@pytest.mark.parametrize(
    "frame", [CAMERA, FrameSpec(image_mirrored=True), FrameSpec(viewpoint="object", actor="sensor")]
)
@pytest.mark.parametrize("motion", DIRECTED)
def test_a_changed_clip_is_told_as_an_open_question_of_the_changed_motion_is(motion, frame):
    types = {kind.kind: type_id for type_id, kind in load_templates().types.items()}

    def truth(kind, of):
        return truth_of(asked_about(motion, types[kind], seed=1), of, frame)

    assert truth("reversed", motion) == truth("undo", motion) == truth("direction", reverse(motion))
    assert truth("mirrored", motion) == truth("direction", mirror(motion))


def asked(type_id, right, stated=0.9):
    return Asked(type_id, {WORDS: right}, stated, "cap")


def test_types_are_pooled_and_methods_without_an_answer_have_no_row():
    own = [asked("T1", True), asked("T1", False), asked("T7", False), asked("T17", True)]
    rows = {row.case: row for row in type_rows("clips", own, seed=0)}
    assert list(rows) == [
        "clips, T1 direction",
        "clips, T7 magnitude",
        "clips, T17 refusal",
        "clips, all directions",
        "clips, all types",
    ]
    assert (rows["clips, all directions"].count, rows["clips, all directions"].right) == (2, 0.5)
    assert (rows["clips, all types"].count, rows["clips, all types"].right) == (4, 0.5)
    assert {row.variant for row in rows.values()} == {WORDS}


def test_what_is_stated_is_held_against_what_came_true():
    own = [asked("T1", True, 1.0), asked("T1", False, 0.8)]
    own += [asked("T17", True, None), asked("T1", False, None)]
    found = calibration(own)
    assert (found["stated"], found["right_of_stated"]) == (2, 0.5)
    assert found["calibration_error"] == pytest.approx((0.0 + 0.8) / 2)  # a bin each
    assert calibration(own[2:]) == {}


def test_a_scripted_model_is_asked_everything_about_simulated_clips(bundle):
    run = Run(is_quick=True, answerer_given=feeling(bundle, Motion.LEFT))
    rows = [Row.from_dict(row.to_dict()) for row in question_rows(run)]
    cases = {row.case for row in rows}
    assert {f"simulated, {name}" for name in ("all types", "T22 order")} < cases
    asked = next(row for row in rows if row.case == "simulated, T1 direction")
    assert asked.count == 3
    assert "unseen wordings" in "\n".join(tables(QUESTIONS, rows))
