"""A conversation keeps what was stated and what a follow-up refers to; doubt changes neither."""

import pytest

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from tests.answering.scripted import believed, feeling, recording


@pytest.fixture
def session(bundle):
    answerer = feeling(bundle, "clockwise")
    return answerer.session(answerer.encode(recording()))


@pytest.mark.parametrize(
    ("first", "then", "way"),
    [
        ("way turn", "mirror again", Motion.COUNTERCLOCKWISE),
        ("mirror way turn", "backwards again", Motion.CLOCKWISE),
        ("way turn", "as-sensor again", Motion.COUNTERCLOCKWISE),
    ],
)
def test_a_change_asks_of_what_was_asked_before(session, first, then, way):
    session.ask(first)
    assert session.ask(then).direction is way
    assert session.frame == FrameSpec()


def test_talk_and_reasons_between_do_not_make_it_forget(session):
    for text in ("way turn", "Thanks!", "Why?", "Are you sure?"):
        session.ask(text)
    assert session.ask("mirror again").direction is Motion.COUNTERCLOCKWISE
    assert session.ask("unit rad again").amount.unit == "rad"


def test_what_no_recording_could_answer_is_nothing_to_lean_on(session):
    turned = session.ask("amount turn")
    assert session.ask("unit percent again").text.startswith("That unit does not fit")
    assert session.ask("Are you sure?").text.endswith(turned.text[1:])
    assert session.ask("unit rad again").amount.unit == "rad"
    assert session.ask("unit deg again").query == "amount turn"


@pytest.mark.parametrize("first", ["way turn ; as word", "way turn ; as json", "touch ; as yes-no"])
def test_a_point_of_view_that_no_sentence_named_is_named_yet(session, first):
    assert " image" not in session.ask(first).text.split('"frame"')[0]
    assert session.ask("cw").text.endswith(", in the camera image.")
    assert not session.ask("cw").text.endswith("image.")


def test_a_point_of_view_is_named_when_it_is_new(session):
    def named(text):
        return " image" in session.ask(text).text

    assert named("Which way is it turning?")
    assert not named("way turn")
    assert not named("cw")
    assert named("mirror way turn")
    assert not named("mirror amount turn")
    session.take_back("mirror amount turn")
    session.take_back("mirror way turn")
    assert not named("way turn")
    assert session.ask("way turn ; amount turn").text.count(" image") == 0
    session.add_clip(session.encoded)
    assert session.ask("way turn ; amount turn").text.count(" image") == 1
    assert named("undo way turn")


def test_what_was_stated_and_understood_holds_there_until_it_is_taken_back(session):
    session.ask("The image is mirrored.")
    assert session.ask("way turn").direction is Motion.COUNTERCLOCKWISE
    session.ask("fact not mirrored")
    assert session.ask("way turn").direction is Motion.CLOCKWISE
    session.ask("fact thread left ; fact side head")
    assert session.ask("loosen").decided == "yes"
    other = session.answerer.session(session.encoded)
    assert (other.frame, other.history) == (FrameSpec(), [])
    session.ask("fact not everything")
    assert session.frame == FrameSpec()
    session.ask("fact mirrored ; fact unclear thread ; tighten")
    assert session.frame == FrameSpec()


def test_what_waits_for_a_fact_is_answered_once_that_is_stated(session):
    assert "size of a pixel" in session.ask("unit mm amount slide ; amount turn").text
    assert session.ask("fact seen sensor").text.startswith("Noted: ")
    session.ask("Thanks!")
    told = session.ask("fact scale 0.06:mm").text
    assert told.startswith("Noted: a pixel measures 0.06 mm. ")
    assert "12 degrees" in told
    assert session.ask("fact scale 0.07:mm").text == "Noted: a pixel measures 0.07 mm."
    session.ask("tighten ; as word")
    assert session.ask("fact thread left ; fact side head").text == "No."
    assert session.ask("not again").decided == "yes"
    assert session.ask("amount turn").text.startswith("About 12")
    assert session.ask("fact not everything").text.startswith("Noted")


def test_a_fact_that_is_refused_answers_nothing(session):
    session.ask("unit mm amount slide")
    assert "0.001 to 2 mm" in session.ask("fact scale 50.0:mm").text
    assert session.ask("fact scale 0.06:mm").text.startswith("Noted: a pixel measures 0.06 mm. ")


def test_doubt_repeats_the_answer_with_its_probability(session):
    told = session.ask("Which way is it turning?")
    sure = session.ask("Are you sure?")
    assert sure.text == f"About {told.confidence:.0%}: i{told.text[1:]}"
    assert session.ask("Why?").text.endswith(f"Therefore: {told.text}")
    assert session.last.text == told.text


def test_a_clip_that_grows_leaves_the_last_answer_to_be_referred_to(session):
    first = session.ask("way turn")
    session.grow(session.answerer.encode(recording()))
    assert len(session.clips) == 1
    assert session.ask("Are you sure?").text.endswith(first.text[1:])
    assert session.ask("mirror again").direction is Motion.COUNTERCLOCKWISE
    session.grow(session.answerer.encode(recording()))
    kept = [turn.encoded is not None for turn in session.history]
    assert kept == [False, False, True]  # each would keep its own frames


def test_a_turn_is_taken_back_with_what_it_stated(session):
    session.ask("Which way?")
    session.ask("fact mirrored ; way all")
    session.take_back("fact mirrored ; way all")
    assert session.frame == FrameSpec()
    assert [turn.question for turn in session.history] == ["Which way?"]
    session.take_back("How far?")
    assert len(session.history) == 1


def test_two_clips_are_compared_and_each_can_be_asked_of(session):
    assert session.ask("Do they turn the same way?").abstained
    session.add_clip(session.answerer.encode(recording(seed=2)))
    same = session.ask("Do they turn the same way?")
    assert (same.decided, same.first.direction) == ("yes", Motion.CLOCKWISE)
    assert session.ask("of-first way turn").direction is Motion.CLOCKWISE


def test_the_history_holds_every_turn_as_plain_values(session):
    for question in ("Which way?", "Are you sure?", "The image is mirrored."):
        session.ask(question)
    turns = session.to_dict()
    assert [turn["question"] for turn in turns] == [turn.question for turn in session.history]
    assert turns[0]["answer"]["direction"] == "clockwise"


def test_what_is_told_of_the_clip_before_rests_on_it(bundle):
    answerer = feeling(bundle, "clockwise")
    session = answerer.session(answerer.encode(recording()))
    answerer.belief = believed("right")
    session.add_clip(answerer.encode(recording(seed=2)))
    first = session.ask("of-first way all")
    assert first.direction is Motion.CLOCKWISE
    assert session.ask("way all").direction is Motion.RIGHT


def test_options_are_those_of_the_clip_that_is_told(bundle):
    answerer = feeling(bundle, "clockwise")
    session = answerer.session(answerer.encode(recording()))
    answerer.belief = believed("right")
    session.add_clip(answerer.encode(recording(seed=2)))
    first = session.ask("of-first way all")
    assert max(first.options, key=first.options.get) == "clockwise"
