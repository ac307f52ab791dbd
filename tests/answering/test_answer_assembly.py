"""Which questions the model answers, which the rules do, and what both refuse."""

import numpy as np
import pytest

from geotlm_lm.answering import NOT_UNDERSTOOD, OPEN_QUESTION, deciding_word
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.language.parse_answer import KINDS, Slots
from tests.answering.scripted import answerer_saying, feeling, recording

SURE = np.exp(2.4) / (np.exp(2.4) + 9)
"""Probability of the sentence that is said, among ten."""

TURNING = "An amount of turning, as measured."


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("And mirrored?", "Counterclockwise, in the camera image, if the clip is mirrored."),
        ("Played backwards?", "Counterclockwise, in the camera image, played backwards."),
        ("Seen from behind?", "Counterclockwise, seen from the object's side."),
        ("Isn't it turning clockwise?", "It is: it goes clockwise in the camera image."),
        ("How fast is it sliding up?", "But no, it goes clockwise in the camera image."),
    ],
)
def test_a_model_of_the_first_kinds_gets_the_later_ones_by_rule(bundle, question, text):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text == text
    assert not answer.abstained
    assert answerer.bundle.speaker.heard == [OPEN_QUESTION]
    assert answer.notes[-1].startswith("Told by rule from the direction: this model was not")


def test_a_rule_keeps_the_probability_of_the_direction_it_started_from(bundle):
    answerer = feeling(bundle, "left")
    answer = answerer.ask(answerer.encode(recording()), "And played backwards?")
    assert answer.direction is Motion.RIGHT
    assert answer.confidence == pytest.approx(SURE)
    assert sum(answer.options.values()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("By how much?", "I cannot tell how far it moved: this model was not trained for amounts."),
        (
            "How fast is it going?",
            "I cannot tell how fast it moved: this model was not trained for amounts.",
        ),
        (
            "Do the two clips go the same way?",
            "I see one clip only; give me a second one to compare it with.",
        ),
        (
            "What happened first?",
            "I see one motion per clip; give me the parts as clips of their own, in order.",
        ),
    ],
)
def test_what_no_rule_can_tell_is_refused_in_one_sentence_without_a_model_run(
    bundle, question, text
):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.abstained, answer.direction) == (text, True, None)
    assert set(answer.timing_ms) == {"choose", "touch", "encode", "total"}


def test_evidence_of_an_untrained_model_is_its_geometry_in_words(bundle):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), "Which half goes which way?")
    assert answer.text.startswith("The whole contact ")
    assert answer.text.endswith(", in the camera image.")
    assert answer.notes[-1].startswith("Told by rule from the geometry")
    assert answerer.bundle.speaker.heard == []


@pytest.mark.parametrize(
    ("fps", "frames", "text"),
    [
        # Frames 0 to 3 at 25 per second take 0.12 s.
        (25.0, 4, "About 110 degrees per second on average, likely 92 to 120."),
        (2.0, 4, "About 8.7 degrees per second on average, likely 7.3 to 9.3."),
        (None, 4, "I cannot tell the speed: it takes 3 frames and a frame rate; give it by fps."),
        (25.0, 2, "I cannot tell the speed: it takes 3 frames and a frame rate; give it by fps."),
    ],
)
def test_a_speed_needs_a_frame_rate_and_three_frames(bundle, fps, frames, text):
    said = {"*": "A speed of turning, as measured."}
    answerer = answerer_saying(bundle, said, temperature=0.1)
    answer = answerer.ask(answerer.encode(recording(frames, fps)), "How fast?")
    assert answer.text == text
    assert answer.abstained == text.startswith("I cannot") == (answer.amount is None)


def test_how_far_is_told_with_the_span_it_lies_in(bundle):
    answerer = answerer_saying(bundle, {"*": TURNING}, temperature=0.1)
    answer = answerer.ask(answerer.encode(recording()), "How far?")
    assert answer.text == "About 13 degrees of turning, likely 11 to 14."
    assert answer.to_dict()["amount"] == {"value": 13, "unit": "deg", "low": 11, "high": 14}
    assert (answer.direction, answer.told_by) == (None, "rule")
    assert answer.confidence == pytest.approx(1.0)


def test_where_nothing_is_felt_to_turn_no_amount_is_told(bundle):
    answerer = answerer_saying(bundle, {"*": "No distance: it is pressing in."})
    answer = answerer.ask(answerer.encode(recording()), "How far?")
    assert (answer.text, answer.amount) == ("No distance: it is pressing in.", None)


def test_an_amount_is_withheld_where_next_to_nothing_touches(bundle):
    answerer = answerer_saying(bundle, {"*": TURNING}, contact_threshold=2.0)
    answer = answerer.ask(answerer.encode(recording()), "How far?")
    assert (answer.abstained, answer.amount) == (True, None)


def test_a_kind_of_motion_heard_for_a_turned_camera_is_told_of_the_open_answer(bundle):
    slide = bundle.grammar.sentence(Slots("class", motion_class=MotionClass.SLIDE))
    opened = bundle.grammar.sentence(Slots("direction", Motion.LEFT))
    answerer = answerer_saying(bundle, {"*": slide, OPEN_QUESTION: opened})
    encoded, frame = answerer.encode(recording()), FrameSpec(image_quarter_turn="clockwise")
    # What is asked in words that no rule knows: its kind is what the model takes it for.
    answer = answerer.ask(encoded, "in why itres?ay does its its it slide?", frame=frame)
    assert (answer.kind, answer.text) == ("class", "A slide.")


def test_facts_of_the_world_alone_leave_the_models_words(bundle):
    answerer = feeling(bundle, "clockwise")
    frame = FrameSpec(thread="left", contact_side="head")
    answer = answerer.ask(answerer.encode(recording()), "Which way?", frame=frame)
    assert answer.text == "Clockwise, in the camera image."


def test_a_rule_withholds_a_direction_without_contact_like_the_model(bundle):
    answerer = feeling(bundle, "clockwise", contact_threshold=1.1)
    answer = answerer.ask(answerer.encode(recording()), "And played backwards?")
    assert answer.text.startswith("I cannot name a direction")
    assert (answer.direction, answer.abstained, answer.confidence) == (None, True, 0.0)


def test_an_open_question_without_an_answer_leaves_the_rules_nothing(bundle):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.speaker.sentences = {"*": "Clockwise, or so."}
    answer = answerer.ask(answerer.encode(recording()), "And played backwards?")
    assert (answer.text, answer.abstained) == (NOT_UNDERSTOOD, True)


@pytest.mark.parametrize("kind", KINDS)
def test_answers_of_a_kind_differ_in_their_deciding_words(bundle, kind):
    slots = [bundle.grammar.parse(text) for text in bundle.grammar.options_for(kind)]
    words = {deciding_word(one) for one in slots}
    claims = {
        (one.verdict, one.letter, one.motion_class, one.unit)
        if one.verdict is not None or one.unit is not None
        else (one.direction, one.letter, one.motion_class)
        for one in slots
    }
    verdicts = kind in ("verify", "contact", "moving", "negation", "premise")
    assert len(words) == (2 if verdicts else len(claims))
