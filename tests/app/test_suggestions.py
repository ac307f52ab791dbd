"""Questions on offer fit the recording, and neither they nor the examples tell how it moves."""

from dataclasses import replace

import pytest
from app.clip_loading import load_clip, perceive
from app.example_clips import FIRST, examples
from app.suggestions import suggested

from app import suggestions
from geotlm_lm import Motion
from tests.app.fakes import FakeAnswerer
from tests.app.test_stage import clip_of

OFFERED = (
    *suggestions.OF_A_CLIP,
    *suggestions.OF_A_RECORDING,
    *suggestions.OF_AN_ANSWER,
    suggestions.IN_MM,
)


def test_of_four_frames_nothing_is_asked_that_needs_a_track():
    offered = suggested(perceive(FakeAnswerer(), clip_of(4)))
    assert offered == list(suggestions.OF_A_CLIP)
    assert not any(one.startswith("When") for one in offered)


def test_of_a_recording_it_is_asked_when_and_in_which_order():
    offered = suggested(perceive(FakeAnswerer(), clip_of(10, fps=25.0)))
    assert offered == list(suggestions.OF_A_RECORDING)


def test_millimetres_are_asked_for_only_where_a_pixel_has_a_size():
    shown = perceive(FakeAnswerer(), clip_of(4))
    assert suggestions.IN_MM not in suggested(shown)
    shown.session.frame = replace(shown.session.frame, mm_per_px=0.06)
    assert suggestions.IN_MM in suggested(shown)


def test_what_was_asked_is_not_offered_again_and_an_answer_may_be_asked_about():
    shown = perceive(FakeAnswerer(), clip_of(4))
    shown.session.answerer.bundle.reader.lines["How far did it go?"] = "amount"
    shown.session.ask("How far did it go?")
    offered = suggested(shown)
    assert "How far did it go?" not in offered
    assert offered[:3] == list(suggestions.OF_AN_ANSWER)


def test_nothing_is_offered_where_nothing_is_open():
    assert suggested(None) == []


@pytest.mark.parametrize("question", OFFERED)
def test_every_question_on_offer_is_understood(answerer, question):
    path = examples()[FIRST].path
    session = answerer.session(load_clip(answerer, path).encoded)
    session.ask("Which way is it moving?")
    reply = session.ask(question)
    assert not reply.text.startswith("I am not sure what you ask")


def test_names_of_examples_tell_what_is_touched_and_not_how_it_moves():
    for example in examples().values():
        words = set(example.name.split()) | set(example.key.split("_"))
        assert not words & {one.value for one in Motion}
    assert next(iter(examples())) == FIRST
    assert [one for one in examples() if one.startswith("key")] == ["key", "key_2"]
