"""Whose sentence an answer is, what both model and rules refuse, and amounts beside it."""

import pytest

from geotlm_lm.answering import NOT_UNDERSTOOD, deciding_word
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.core.twist import Component
from geotlm_lm.language.parse_answer import KINDS, Slots
from tests.answering.scripted import answerer_saying, believed, feeling, measuring, recording


@pytest.mark.parametrize(
    ("question", "begins"),
    [
        ("And mirrored?", "It turns counterclockwise, about 12 degrees, in the camera image, if"),
        ("Played backwards?", "It turns counterclockwise, about 12 degrees, in the camera image,"),
        ("Seen from behind?", "It turns counterclockwise, about 12 degrees, seen from the object"),
        ("Isn't it turning clockwise?", "It is: it turns clockwise, about 12 degrees, in the"),
        ("How fast is it sliding up?", "But no, it does not slide; it turns clockwise, about 12"),
    ],
)
def test_what_follows_from_the_motion_is_told_by_rule(bundle, question, begins):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(begins)
    assert (answer.abstained, answer.told_by) == (False, "rule")


def test_kinds_that_only_rules_tell_run_no_model(bundle):
    answerer = feeling(bundle, "left")
    answer = answerer.ask(answerer.encode(recording()), "And played backwards?")
    assert (answer.direction, answer.confidence) == (Motion.RIGHT, pytest.approx(0.97))
    assert answerer.bundle.speaker.heard == []


def test_the_models_sentence_stands_where_it_says_what_is_felt(bundle):
    said = {"*": "Clockwise, in the camera image."}
    for belief, told_by in (
        (believed("clockwise"), "model"),
        (believed("counterclockwise"), "rule"),
        (believed("clockwise", "left"), "rule"),
        (believed("clockwise", share=0.6), "rule"),
    ):
        answerer = answerer_saying(bundle, said, belief=belief)
        answer = answerer.ask(answerer.encode(recording()), "Which way is it moving?")
        assert answer.told_by == told_by
        assert (answer.text == said["*"]) == (told_by == "model")


def test_where_it_is_doubtful_that_it_moves_barely_is_said(bundle):
    for share, begins in (
        (0.6, "It turns clockwise, barely: about 1 degree, in"),
        (0.4, "It hardly turns, if at all clockwise, about 1 degree, in"),
        (0.01, "It does not turn: it is touching but not moving."),
    ):
        belief = believed("clockwise", share=share, deg=1.0)
        answerer = answerer_saying(bundle, {"*": "A rotation."}, belief=belief)
        answer = answerer.ask(answerer.encode(recording()), "Which way is it turning?")
        assert answer.text.startswith(begins)
        assert answer.direction is (Motion.CLOCKWISE if share > 0.25 else Motion.STILL)


def test_the_way_of_what_may_as_well_not_count_is_never_told_as_sure(bundle):
    """As a held grip and an untouched gel are believed: at 0.09 that they turn, at most."""
    for share in (0.02, 0.09, 0.3):
        belief = believed("clockwise", share=share, deg=0.3)
        answerer = answerer_saying(bundle, {"*": "A rotation."}, belief=belief)
        encoded = answerer.encode(recording())
        answer = answerer.ask(encoded, "Which way is it turning?")
        assert answer.text.startswith("It hardly turns, if at all clockwise, about ")
        assert answer.confidence <= 0.75
        assert answer.motion.counts[Component.TURN] < 0.5
        opened = answerer.ask(encoded, "Which way is it moving?")
        claimed = answerer.ask(encoded, "Is it turning?")
        assert (opened.direction, claimed.decided) == (Motion.STILL, "no")
        assert claimed.confidence == pytest.approx(1 - share)


@pytest.mark.parametrize(
    ("question", "text"),
    [
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
def test_what_one_clip_cannot_tell_is_refused_in_one_sentence(bundle, question, text):
    said = {
        "*": "To compare takes two clips.",
        "What happened first?": "One clip shows one motion.",
    }
    answerer = answerer_saying(bundle, said)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.abstained, answer.direction) == (text, True, None)


def test_evidence_of_an_untrained_model_is_its_geometry_in_words(bundle):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), "Which half goes which way?")
    assert answer.text.startswith("The whole contact ")
    assert answer.text.endswith(", in the camera image.")


def test_evidence_that_concludes_another_motion_is_not_told(bundle):
    said = bundle.grammar.sentence(Slots("evidence", Motion.LEFT))
    answerer = answerer_saying(bundle, {"*": said}, belief=believed("clockwise"))
    answer = answerer.ask(answerer.encode(recording()), "Which half goes which way?")
    assert answer.text.startswith("The whole contact ")


@pytest.mark.parametrize(
    ("fps", "frames", "text"),
    [
        # Frames 0 to 3 at 25 per second take 0.12 s.
        (25.0, 4, "About 100 degrees per second on average, likely 92 to 110."),
        (2.0, 4, "About 8 degrees per second on average, likely 7.3 to 8.7."),
        (None, 4, "I cannot tell the speed: it takes 3 frames and a frame rate; give it by fps."),
        (25.0, 2, "I cannot tell the speed: it takes 3 frames and a frame rate; give it by fps."),
    ],
)
def test_a_speed_needs_a_frame_rate_and_three_frames(bundle, fps, frames, text):
    answerer = measuring(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording(frames, fps)), "How fast?")
    assert answer.text == text
    assert answer.abstained == text.startswith("I cannot") == (answer.amount is None)


def test_how_far_is_told_with_the_span_it_lies_in(bundle):
    answerer = measuring(bundle, "clockwise", deg=13.0)
    answer = answerer.ask(answerer.encode(recording()), "How far?")
    assert answer.text == "About 13 degrees of turning, likely 11 to 15."
    assert answer.to_dict()["amount"] == {"value": 13, "unit": "deg", "low": 11, "high": 15}
    assert (answer.direction, answer.told_by) == (None, "rule")
    assert answer.confidence == pytest.approx(0.97, abs=0.01)


def test_where_nothing_is_felt_to_turn_no_amount_is_told(bundle):
    answerer = answerer_saying(bundle, {"*": "No distance: it is still."}, belief=believed("still"))
    answer = answerer.ask(answerer.encode(recording()), "How far?")
    assert (answer.text, answer.amount) == ("No distance: it is still.", None)


def test_an_amount_is_withheld_where_next_to_nothing_touches(bundle):
    answerer = answerer_saying(bundle, {"*": "A rotation."}, contact_threshold=2.0)
    answer = answerer.ask(answerer.encode(recording()), "How far?")
    assert (answer.abstained, answer.amount) == (True, None)


def test_a_motion_presumed_is_judged_with_its_amount(bundle):
    answerer = measuring(bundle, "right")
    answer = answerer.ask(answerer.encode(recording(size=(224, 224))), "How far did it slide left?")
    assert answer.text == "But no, it slides right, about 14 px, in the camera image."
    assert (answer.decided, answer.amount.word) == ("it does not", "14 px")


def test_what_is_asked_in_words_that_no_rule_knows_is_what_the_model_takes_it_for(bundle):
    slide = bundle.grammar.sentence(Slots("class", motion_class=MotionClass.SLIDE))
    answerer = answerer_saying(bundle, {"*": slide}, belief=believed("left"))
    encoded, frame = answerer.encode(recording()), FrameSpec(image_quarter_turn="clockwise")
    answer = answerer.ask(encoded, "in why itres?ay does its its its it slide?", frame=frame)
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


def test_words_that_are_none_of_the_answers_are_not_told(bundle):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.speaker.sentences = {"*": "Clockwise, or so."}
    answer = answerer.ask(answerer.encode(recording()), "Hm, and the thing of it?")
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
