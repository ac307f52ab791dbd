"""Truths come from labels alone: who believes what is right is graded right, who believes another
motion is graded wrong; rows and calibration are counted by hand.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.answering.evidence_of import recording_of
from geotlm_lm.benchmarks.harness import Row, Run
from geotlm_lm.benchmarks.questions import (
    QUESTIONS,
    UNSEEN,
    WORDS,
    Asked,
    Truth,
    calibration,
    claim_of,
    is_right,
    question_rows,
    truth_of,
    type_rows,
)
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.query.reader import Reading
from geotlm_lm.query.types import WAY_ATOMS
from tests.answering.scripted import ScriptedReader, believed, feeling, recording
from tests.tiny_bundle import tiny_bundle

CAMERA, HEAD = FrameSpec(), FrameSpec(contact_side="head", thread="right")
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


ATOMS = {way: atom for atom, way in WAY_ATOMS.items()} | {
    Motion.STILL: "still",
    Motion.NONE: "none",
}
LINES = {
    "direction": "way all",
    "class": "kind",
    "contact": "touch",
    "moving": "move",
    "magnitude": "extent",
    "rate": "speed move",
    "comparison": "same way all",
    "evidence": "why",
    "viewpoint": "behind way all",
    "actor": "sensor way all",
    "thread": "choose tighten | loosen",
    "mirrored": "mirror way all",
    "reversed": "backwards way all",
    "refusal": "cannot material",
    "premise": "way all",
    "confidence": "sure",
    "undo": "undo way all",
    "order": "story",
}
"""What questions of a kind mean, where they neither claim nor offer a motion."""


def line_of(asked):
    if asked.slots.kind in ("verify", "negation"):
        denied = "not " * (asked.slots.kind == "negation")
        return f"{denied}{ATOMS[claim_of(asked)]}"
    if asked.slots.kind == "choice":
        answers = load_templates().types["T3"].answers
        slots = [answers[sentence] for sentence in asked.options]
        return "choose " + " | ".join(f"{one.letter} {ATOMS[one.direction]}" for one in slots)
    return LINES[asked.slots.kind]


def asked_about(motion, type_id, seed=0):
    return questions_for(LABELS[motion], np.random.default_rng(seed), types=[type_id])[0]


@cache
def perceived(bundle):
    return Answerer(bundle).encode(recording(fps=25.0, size=(224, 224)))


def is_answered_right(bundle, asked, motion, felt, frame=CAMERA):
    """Tell whether who believes `felt` answers a question about `motion` right."""
    answerer = feeling(bundle, belief=believed(felt, deg=20.0, px=10.0))
    answerer.bundle.reader.lines[asked.question] = line_of(asked)
    encoded = perceived(bundle)
    answer = answerer.ask(encoded, asked.question, frame=frame)
    truth = truth_of(asked, motion, frame, seconds=recording_of(encoded).seconds)
    return is_right(answer, truth)


@pytest.mark.parametrize("type_id", TYPES)
def test_who_believes_what_is_right_is_right(bundle, type_id):
    for seed, motion in enumerate(Motion):
        asked = asked_about(motion, type_id, seed)
        frame = HEAD if asked.slots.kind == "thread" else CAMERA
        assert is_answered_right(bundle, asked, motion, motion, frame), asked.question


@pytest.mark.parametrize(
    "type_id", ["T1", "T2", "T3", "T4", "T10", "T11", "T12", "T14", "T15", "T18", "T19", "T21"]
)
def test_who_believes_the_opposite_is_wrong(bundle, type_id):
    asked = asked_about(Motion.LEFT, type_id, seed=6)
    assert not is_answered_right(bundle, asked, Motion.LEFT, Motion.RIGHT)


def test_a_right_hand_thread_at_its_head_tightens_clockwise():
    asked = asked_about(Motion.CLOCKWISE, "T13")
    assert truth_of(asked, Motion.CLOCKWISE, HEAD).decided == "tighten"
    assert truth_of(asked, Motion.CLOCKWISE, replace(HEAD, thread="left")).decided == "loosen"
    assert truth_of(asked, Motion.CLOCKWISE, replace(HEAD, thread=None)).abstains


def answer_of(bundle, line, felt):
    answerer = feeling(bundle, belief=believed(felt, deg=20.0))
    return answerer.ask(perceived(bundle), line, frame=HEAD)


@pytest.mark.parametrize(
    "line",
    [
        "tighten",
        "not loosen",
        "not not tighten",
        "loosen",
        "way thread",
        "choose A loosen | B tighten",
    ],
)
def test_a_thread_is_judged_however_it_is_asked_about(bundle, line):
    for felt, truth in (("clockwise", "tighten"), ("counterclockwise", "loosen")):
        answer = answer_of(bundle, line, felt)
        assert is_right(answer, Truth("thread", truth))
        assert not is_right(answer, Truth("thread", {"tighten": "loosen"}.get(truth, "tighten")))


@pytest.mark.parametrize(
    ("line", "right"),
    [("begin first cw-events", True), ("cannot cause", True), ("way all", False), ("cw", True)],
)
def test_of_a_false_premise_nothing_is_claimed_that_four_frames_do_not_tell(bundle, line, right):
    answer = answer_of(bundle, line, "clockwise")
    assert is_right(answer, Truth("premise", direction=Motion.CLOCKWISE))
    assert is_right(answer, Truth("premise", direction=Motion.LEFT)) == (right and line != "cw")


@pytest.mark.parametrize(("felt", "right"), [(23.0, True), (27.0, False), (15.0, False)])
def test_an_amount_is_right_within_a_fifth_and_in_its_unit(bundle, felt, right):
    motion = Motion.CLOCKWISE
    asked = asked_about(motion, "T7")  # 20 degrees
    answerer = feeling(bundle, belief=believed(motion, deg=felt))
    answer = answerer.ask(perceived(bundle), "amount turn")
    truth = truth_of(asked, motion, CAMERA)
    assert is_right(answer, truth) == right
    assert not is_right(answer, replace(truth, unit="px"))


def asked(type_id, right, stated=0.9):
    return Asked(type_id, {WORDS: right, UNSEEN: False}, stated, "cap")


def test_types_are_pooled_for_each_wording_apart():
    own = [asked("T1", True), asked("T1", False), asked("T7", False), asked("T17", True)]
    found = list(type_rows("clips", own, seed=0))
    rows = {row.case: row for row in found if row.variant == WORDS}
    assert list(rows) == [
        "clips, T1 direction",
        "clips, T7 magnitude",
        "clips, T17 refusal",
        "clips, all directions",
        "clips, all types",
    ]
    assert (rows["clips, all directions"].count, rows["clips, all directions"].right) == (2, 0.5)
    assert (rows["clips, all types"].count, rows["clips, all types"].right) == (4, 0.5)
    assert {row.right for row in found if row.variant == UNSEEN} == {0}


def test_what_is_stated_is_held_against_what_came_true():
    own = [asked("T1", True, 1.0), asked("T1", False, 0.8)]
    own += [asked("T17", True, None), asked("T1", False, None)]
    found = calibration(own)
    assert (found["stated"], found["right_of_stated"]) == (2, 0.5)
    assert found["calibration_error"] == pytest.approx((0.0 + 0.8) / 2)  # a bin each
    assert calibration(own[2:]) == {}


class ReadingWay(ScriptedReader):
    def readings(self, text, most=2, sure=1.0, unlikely=frozenset()):
        return [Reading("way all", (), (), self.probability, self.probability)]


def test_everything_is_asked_about_simulated_clips():
    answerer = Answerer(replace(tiny_bundle(), reader=ReadingWay()))
    rows = [
        Row.from_dict(row.to_dict())
        for row in question_rows(Run(is_quick=True, answerer_given=answerer))
    ]
    cases = {row.case for row in rows}
    assert {f"simulated, {name}" for name in ("all types", "T22 order")} < cases
    asked = next(row for row in rows if row.case == "simulated, T1 direction")
    assert asked.count == 3
    assert "unseen wordings" in "\n".join(tables(QUESTIONS, rows))
