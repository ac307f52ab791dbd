"""What an answer leans to where the question takes a turn, or a slide, for granted."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch
from jsonschema import validate

from geotlm_lm import answer_schema
from geotlm_lm.answering import Answerer
from geotlm_lm.answering.abstention import UNRECOGNISED
from geotlm_lm.answering.answer import Answer, Lean
from geotlm_lm.answering.conditional_direction import with_conditional_direction
from geotlm_lm.conversation.motion_answers import CAMERA
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion
from tests.answering.scripted import answerer_saying, recording

TURN, SLIDE = "Which way is it turning?", "Which way did it slide?"
PRESS_THEN_CLOCKWISE = {"press": 0.8, "clockwise": 0.15, "counterclockwise": 0.01, "left": 0.04}


def answered(options, kind="direction", frame=CAMERA):
    told = max(options, key=options.get)
    return Answer(
        text="It is told.",
        direction=Motion(told),
        confidence=options[told],
        abstained=False,
        frame=frame,
        options=options,
        evidence={},
        timing_ms={"total": 1.0},
        kind=kind,
        frames_used=(0, 1, 2, 3),
        notes=("As before.",),
        decided=told,
    )


class Probing:
    """A probe that holds what a test wrote down, in the camera image."""

    def __init__(self, odds):
        self.odds = odds

    def probabilities(self, token, among):
        odds = torch.tensor([self.odds.get(motion.value, 1e-9) for motion in among])
        return (odds / odds.sum())[None]


def leaning(question, answer, contact_share=0.2, odds=None):
    def withholds(claim, share):
        return claim in DIRECTED and share < 0.01

    seen = {
        answer.frame.in_the_image(Motion(word)).value: answer.options[word]
        for word in answer.options
    }
    bundle = SimpleNamespace(
        calibration=SimpleNamespace(withholds=withholds),
        model=SimpleNamespace(probe=Probing(odds or seen)),
    )
    encoded = SimpleNamespace(
        contact_share=contact_share, perception=SimpleNamespace(fused_token=None)
    )
    return with_conditional_direction(bundle, encoded, question, answer)


def test_a_turn_asked_after_is_told_beside_a_press():
    answer = leaning(TURN, answered(PRESS_THEN_CLOCKWISE))
    told = "If it turns at all, it goes clockwise in the camera image: 94% among the two turns."
    assert answer.lean == Lean(Motion.CLOCKWISE, pytest.approx(0.9375), told)
    assert answer.direction == Motion.PRESS
    assert answer.notes == ("As before.", told)
    lean = answer.to_dict()["lean"]
    assert lean == {"direction": "clockwise", "share": 0.9375, "text": told}


def test_a_slide_asked_after_is_told_beside_a_turn():
    answer = leaning(SLIDE, answered({"clockwise": 0.6, "left": 0.3, "up": 0.05, "press": 0.05}))
    assert answer.lean.direction == Motion.LEFT
    assert answer.lean.share == pytest.approx(0.3 / 0.35)
    assert "slides" in answer.notes[-1]


@pytest.mark.parametrize(
    ("question", "options"),
    [
        ("Which way is it moving?", PRESS_THEN_CLOCKWISE),  # takes no turn for granted
        (TURN, {"clockwise": 0.5, "counterclockwise": 0.4, "press": 0.1}),  # tells a turn
        (TURN, {"none": 0.9, "clockwise": 0.1}),  # nothing there to turn
        (TURN, {"press": 0.8, "clockwise": 0.6 * 0.2, "counterclockwise": 0.4 * 0.2}),  # undecided
        (TURN, {"press": 1.0}),
        (TURN, {"press": 0.99, "clockwise": 0.01}),  # too little to share out
        (TURN, {}),
    ],
)
def test_nothing_leans(question, options):
    answer = answered(options or {"press": 1.0})
    if not options:
        answer = answered({"press": 1.0}, kind=None)
    assert leaning(question, answer) == answer


@pytest.mark.parametrize(
    ("change", "contact_share"),
    [
        *(({"kind": kind}, 0.2) for kind in ("verify", "mirrored", "reversed", "actor", "thread")),
        ({"direction": None, "text": UNRECOGNISED}, 0.2),  # withheld for want of a touch
        ({}, 0.0),
    ],
)
def test_another_question_and_what_is_not_touched_are_left_alone(change, contact_share):
    answer = replace(answered(PRESS_THEN_CLOCKWISE), **change)
    assert leaning(TURN, answer, contact_share) == answer


@pytest.mark.parametrize("begins", ["Next likeliest", "Likelier by the probabilities"])
def test_what_leans_is_not_told_twice(begins):
    answer = answered(PRESS_THEN_CLOCKWISE)
    next_one = f"{begins}, at 15%: clockwise."
    answer = leaning(TURN, replace(answer, notes=("As before.", next_one)))
    assert answer.notes == ("As before.", answer.lean.text)
    other = leaning(TURN, replace(answer, notes=("Next likeliest, at 15%: left.",), lean=None))
    assert len(other.notes) == 2


def test_a_withheld_guess_may_lean():
    answer = replace(answered(PRESS_THEN_CLOCKWISE), direction=None, abstained=True)
    assert leaning(TURN, answer).lean.direction == Motion.CLOCKWISE


def test_the_probe_tips_what_the_words_leave_open():
    undecided = answered({"press": 0.8, "clockwise": 0.1, "counterclockwise": 0.1})
    lean = leaning(TURN, undecided, odds={"clockwise": 0.1, "counterclockwise": 0.9}).lean
    assert lean.direction == Motion.COUNTERCLOCKWISE
    assert lean.share == pytest.approx(0.75)  # the geometric mean of 1 : 1 and 9 : 1


def test_opinions_that_share_no_motion_tip_nothing():
    opposed = answered({"press": 0.8, "clockwise": 0.2, "counterclockwise": 0.0})
    assert leaning(TURN, opposed, odds={"clockwise": 0.0, "counterclockwise": 1.0}) == opposed


def test_where_the_probe_holds_the_opposite_nothing_leans():
    answer = answered(PRESS_THEN_CLOCKWISE)
    assert leaning(TURN, answer, odds={"clockwise": 0.1, "counterclockwise": 0.9}) == answer


@pytest.mark.parametrize("frame", [FrameSpec(viewpoint="object"), FrameSpec(actor="sensor")])
@pytest.mark.parametrize(
    ("question", "told"),
    [(TURN, Motion.CLOCKWISE), (TURN, Motion.COUNTERCLOCKWISE), (SLIDE, Motion.LEFT)],
)
def test_the_probe_sees_the_camera_image_whatever_frame_is_told_in(frame, question, told):
    among = ROTATIONS if question == TURN else SLIDES
    options = {"press": 0.6} | {motion.value: 0.4 / len(among) for motion in among}
    odds = {frame.in_the_image(told).value: 0.99}
    answer = leaning(question, answered(options, "viewpoint", frame), odds=odds)
    assert answer.lean.direction == told


def pressing(bundle):
    """An answerer that says press, and nearly as likely takes it for clockwise."""
    answerer = answerer_saying(bundle, {"*": "It is pressing in."})
    answerer.bundle.speaker.likes = "Clockwise, in the camera image."
    probe = Probing({"clockwise": 0.9, "counterclockwise": 0.1})
    model = replace(answerer.bundle.model, probe=probe)
    return Answerer(replace(answerer.bundle, model=model))


def test_a_user_who_asks_which_way_it_turns_is_told_through_every_door(bundle):
    answerer = pressing(bundle)
    encoded = answerer.encode(recording())
    asked = answerer.ask(encoded, TURN)
    in_session = answerer.session(encoded).ask(TURN)
    *_, streamed = answerer.stream(encoded, TURN)
    for answer in (asked, in_session, streamed):
        assert answer.lean is not None
        assert answer.lean.direction == Motion.CLOCKWISE
        assert answer.lean.text in answer.notes
    validate(asked.to_dict(), answer_schema())
    assert answerer.ask(encoded, "Which way is it moving?").lean is None


def test_a_lean_seen_from_the_other_side_turns_round(bundle):
    answerer = pressing(bundle)
    question = "Seen from the object's side, which way does it turn?"
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.lean.direction == Motion.COUNTERCLOCKWISE
    assert "seen from the object's side" in answer.lean.text
