"""Behaviour of the seam, with a bundle of random weights and a scripted speaker."""

import json
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.answering import Answerer, check_question, deciding_word
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.recordings import limits
from geotlm_lm.recordings.read import read_clip
from tests.answering import scripted


def answerer_saying(bundle, slots=None, text=None, **calibration):
    """An answerer whose model says one sentence whatever it is asked."""
    sentence = text if text is not None else bundle.grammar.sentence(slots)
    return scripted.answerer_saying(bundle, {"*": sentence}, **calibration)


def recording(frames=4):
    """One without a background."""
    return replace(scripted.recording(frames), background=None)


def test_the_time_of_a_recording_read_at_a_stride_is_its_own(bundle, tmp_path, monkeypatch):
    frames = recording(24).frames
    np.savez(tmp_path / "clip.npz", frames=frames, fps=25.0)
    monkeypatch.setattr(limits, "KEPT_BYTES", 8 * frames[0].nbytes)
    encoded = Answerer(bundle).encode(read_clip(tmp_path / "clip.npz"), span=(0, 21))
    assert encoded.track.seconds == pytest.approx(21 / 25)
    assert 0 < encoded.seconds <= 21 / 25


@pytest.mark.parametrize(("given", "found"), [("clip.npz", "str"), (np.zeros(3), "ndarray")])
def test_what_is_no_clip_is_refused_with_what_to_do(bundle, given, found):
    with pytest.raises(TypeError) as caught:
        Answerer(bundle).encode(given)
    assert str(caught.value) == (
        f"encode takes a Clip, found {found}; read a file by read_clip(path), or make one of an "
        f"array by Clip(frames)"
    )


def test_what_is_no_question_is_refused_with_what_to_do():
    with pytest.raises(TypeError) as caught:
        check_question(None)
    assert str(caught.value) == (
        "a question is a str, found NoneType; ask for example 'Which way does it turn?'"
    )


CLOCKWISE = Slots("direction", direction=Motion.CLOCKWISE)


def test_an_answer_carries_direction_frame_options_evidence_and_timing(bundle):
    answerer = answerer_saying(bundle, CLOCKWISE)
    answer = answerer.ask(answerer.encode(recording()), "Which way does it turn?")
    assert answer.direction is Motion.CLOCKWISE
    assert not answer.abstained
    assert set(answer.options) == {motion.value for motion in Motion}
    assert answer.confidence == pytest.approx(0.97)
    assert answer.motion.to_dict()["turn"]["way"] == "clockwise"
    assert set(answer.timing_ms) == {"choose", "touch", "encode", "check", "total"}
    assert set(answer.evidence["regions"]) >= {"upper_minus_lower", "left_minus_right"}
    required = {"text", "direction", "confidence", "abstained", "frame", "options", "timing_ms"}
    assert required <= set(json.loads(json.dumps(answer.to_dict())))


def test_an_answer_that_is_likelier_wrong_than_right_is_withheld_and_told_as_a_guess(bundle):
    belief = scripted.believed("clockwise", share=0.51)
    belief.ways[Motion.CLOCKWISE], belief.ways[Motion.COUNTERCLOCKWISE] = 0.4, 0.3
    answerer = answerer_saying(bundle, CLOCKWISE, belief=belief)
    answer = answerer.ask(answerer.encode(recording()), "Which way?")
    assert answer.text.startswith("I cannot tell for sure, 40%: It turns clockwise, barely: about")
    assert (answer.direction, answer.decided, answer.confidence) == (None, None, 0.0)
    assert answer.abstained


def test_an_amount_is_told_however_unsure_its_number_is(bundle):
    belief = scripted.believed("clockwise", spread=1.0)
    answerer = answerer_saying(bundle, CLOCKWISE, belief=belief)
    answer = answerer.ask(answerer.encode(recording()), "How far did it turn?")
    assert answer.amount is not None
    assert answer.confidence < 0.5 < answer.options["rotation"]


def test_a_direction_without_contact_becomes_an_abstention(bundle):
    answerer = answerer_saying(bundle, CLOCKWISE, contact_threshold=1.1)
    answer = answerer.ask(answerer.encode(recording()), "Which way does it turn?")
    assert answer.abstained
    assert answer.direction is None
    assert answer.text.startswith("I cannot name a direction: I see next to no contact")
    assert answer.confidence == 0.0


def test_words_outside_the_answers_are_an_abstention_of_unknown_kind(bundle):
    answerer = answerer_saying(bundle, text="Clockwise, I would guess, or so.")
    answer = answerer.ask(answerer.encode(recording()), "rotation sense pls")
    assert (answer.kind, answer.direction, answer.abstained) == (None, None, True)
    assert answer.confidence == 0.0


def test_where_the_question_tells_the_kind_the_belief_is_told_whatever_the_model_writes(
    bundle,
):
    answerer = answerer_saying(bundle, text="Clockwise, I would guess, or so.")
    answer = answerer.ask(answerer.encode(recording()), "Which way does it turn?")
    assert answer.text.startswith("It does not turn; it slides left")
    assert (answer.kind, answer.told_by, answer.direction) == ("direction", "rule", Motion.LEFT)


def test_a_refusal_abstains(bundle):
    answerer = answerer_saying(bundle, Slots("refusal"))
    answer = answerer.ask(answerer.encode(recording()), "What colour is it?")
    assert answer.abstained
    assert answer.direction is None


@pytest.mark.parametrize(
    "question",
    ["A) right B) left?", "(a) right (b) left", "a. right, b. left", "A: right; B: left"],
)
def test_multiple_choice_scores_only_the_letters_offered(bundle, question):
    said = Slots("choice", direction=Motion.LEFT, letter="B")
    answerer = answerer_saying(bundle, said)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.direction is Motion.LEFT
    assert {name[0] for name in answer.options} == {"A", "B"}


def test_a_clip_is_encoded_once_for_many_questions(bundle, monkeypatch):
    answerer, calls = answerer_saying(bundle, CLOCKWISE), []
    perceive = type(bundle.model).perceive
    monkeypatch.setattr(
        type(bundle.model), "perceive", lambda *args: calls.append(1) or perceive(*args)
    )
    for length in (4, 9):
        encoded = answerer.encode(recording(length))
        encoded.belief  # noqa: B018
        before = len(calls)
        for question in ("Which way?", "Is it turning left?", "Is it moving?"):
            answerer.ask(encoded, question)
        assert len(calls) == before
        assert len(encoded.clip) == 4


def test_an_unknown_background_is_estimated_and_said(bundle):
    encoded = answerer_saying(bundle, CLOCKWISE).encode(recording())
    assert encoded.clip.background is not None
    assert any("estimated" in note for note in encoded.clip.notes)


@pytest.mark.parametrize("question", ["", "   ", "\n\t"])
def test_an_empty_question_is_refused(bundle, question):
    answerer = answerer_saying(bundle, CLOCKWISE)
    with pytest.raises(UsageError, match="the question is empty; ask for example"):
        answerer.ask(answerer.encode(recording()), question)


def test_a_question_that_is_no_text_is_refused():
    with pytest.raises(UsageError, match="holds bytes that are no text"):
        check_question("which way \udce4?")


def test_an_endless_question_is_refused(bundle):
    answerer = answerer_saying(bundle, CLOCKWISE)
    with pytest.raises(UsageError, match="the question has 600 characters, expected at most 500"):
        answerer.ask(answerer.encode(recording()), "x" * 600)


def test_a_single_frame_is_refused(bundle):
    with pytest.raises(UnreadableClip, match="only 1 frame"):
        answerer_saying(bundle, CLOCKWISE).encode(recording(1))


def test_every_answer_of_the_grammar_has_a_deciding_word(bundle):
    kinds = ("direction", "verify", "choice", "class", "contact", "moving", "refusal")
    for kind in kinds:
        for sentence in bundle.grammar.options_for(kind):
            assert deciding_word(bundle.grammar.parse(sentence))
