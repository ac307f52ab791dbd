"""A conversation keeps its frame and its answers; doubt changes neither."""

import pytest

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from tests.answering.scripted import answerer_saying, feeling, measuring, recording


@pytest.fixture
def session(bundle):
    answerer = feeling(bundle, "clockwise")
    return answerer.session(answerer.encode(recording()))


def test_doubt_runs_no_model(session):
    session.ask("Which way?")
    heard = list(session.answerer.bundle.speaker.heard)
    session.ask("Are you sure?")
    assert session.answerer.bundle.speaker.heard == heard


def test_a_refusal_is_repeated_as_it_is(session):
    refusal = session.ask("Compare the two clips.")
    assert session.ask("Really?") == refusal


def test_now_asks_the_question_before_of_a_new_clip(session):
    first = session.ask("Is it turning clockwise?")
    session.add_clip(session.answerer.encode(recording(seed=2)))
    assert session.ask("And now?").decided == first.decided == "yes"


@pytest.mark.parametrize("first", ["Which way is it turning?", "How far did it turn?"])
def test_a_change_asks_of_what_was_asked_before(bundle, first):
    answerer = feeling(bundle, "left", "clockwise")
    session = answerer.session(answerer.encode(recording()))
    session.ask(first)
    for question, begins in (
        ("And played backwards?", "It turns counterclockwise, about "),
        ("And mirrored?", "It turns counterclockwise, about "),
        ("And for the sensor?", "The sensor turns counterclockwise, about "),
        ("Seen from behind?", "It turns counterclockwise, about "),
    ):
        text = session.ask(question).text
        assert text.startswith(begins)
        assert "slides" not in text
    assert "slides" in session.ask("Mirrored, what happens?").text
    assert "slides" in session.ask("And played backwards?").text
    assert session.frame == FrameSpec()
    session.ask(first)
    assert session.ask("The image is mirrored.").kind == "frame"


def test_a_turn_is_taken_back_with_what_it_said_of_the_frame(session):
    session.ask("Which way?")
    session.ask("The image is mirrored. Which way?")
    session.take_back("The  image is mirrored. Which way?")
    assert session.frame == FrameSpec()
    assert [turn.question for turn in session.history] == ["Which way?"]


def test_only_the_last_turn_is_taken_back(session):
    session.ask("Which way?")
    session.ask("Is it sliding?")
    session.take_back("Which way?")
    assert len(session.history) == 2


@pytest.mark.parametrize("asks", ["Do they turn the same way?", "What happened first?"])
def test_two_clips_of_a_turned_image_wait_for_its_sense(session, asks):
    session.add_clip(session.answerer.encode(recording(seed=2)))
    asked = session.ask(f"The camera is mounted sideways. {asks}")
    assert asked.text.startswith("I cannot tell a direction without the way it is turned")
    assert asked.abstained
    first, second = session.clips
    compared = session.answerer.compare(first, second, f"The camera is mounted sideways. {asks}")
    assert (compared.text, compared.relation) == (asked.text, "unknown")


def test_doubt_after_a_fact_is_about_the_answer_before_it(session):
    session.ask("Which way?")
    session.ask("Left-hand thread.")
    assert session.ask("Are you sure?").text.endswith("Clockwise, in the camera image.")


def test_two_clips_are_compared_and_told_in_order(bundle):
    answerer = feeling(bundle, "clockwise", contact_threshold=0.0)
    session = answerer.session(answerer.encode(recording()))
    assert session.ask("Do they turn the same way?").abstained
    session.add_clip(session.answerer.encode(recording(seed=2)))
    same = session.ask("Do they turn the same way?")
    assert same.text == "The same: of both clips, it goes clockwise in the camera image."
    assert (same.relation, same.first.direction) == ("same", Motion.CLOCKWISE)
    order = session.ask("What happened first?")
    assert order.motions == (Motion.CLOCKWISE, Motion.CLOCKWISE)
    assert session.ask("Are you sure?").text.endswith(order.text)


def test_the_history_holds_every_turn_as_plain_values(session):
    for question in ("Which way?", "Are you sure?", "The image is mirrored."):
        session.ask(question)
    turns = session.to_dict()
    assert [turn["question"] for turn in turns] == [turn.question for turn in session.history]
    assert turns[0]["answer"]["direction"] == "clockwise"
    assert [turn.is_repeated for turn in session.history] == [False, True, False]


def test_two_sessions_share_nothing(bundle):
    answerer = feeling(bundle, "left")
    encoded = answerer.encode(recording())
    one, other = answerer.session(encoded), answerer.session(encoded)
    one.ask("The image is mirrored.")
    assert other.frame == FrameSpec()
    assert other.history == []


@pytest.mark.parametrize("again", ["Are you sure?", "Say that again?", "Really?"])
def test_an_answer_said_again_after_another_clip_names_the_clip_before(session, again):
    session.ask("Which way?")
    session.add_clip(session.answerer.encode(recording(seed=2)))
    said = session.ask(again).text
    assert said.endswith("Of the clip before: Clockwise, in the camera image.")
    session.ask("Which way?")
    assert "before" not in session.ask(again).text


def test_where_after_a_contact_asks_for_its_place(bundle):
    said = {
        "Is anything touching?": "Yes, something is touching the gel.",
        "*": "Left, in the camera image.",
    }
    answerer = answerer_saying(bundle, said)
    session = answerer.session(answerer.encode(recording()))
    assert session.ask("where?").kind == "direction"
    session.ask("Is anything touching?")
    assert session.ask("where?").kind == "contact"
    assert session.history[-1].meant == "Where is the contact?"


@pytest.mark.parametrize("asked", ["How far did it turn?", "How fast is it turning?"])
def test_the_range_is_that_of_the_amount_told_last(bundle, asked):
    answerer = measuring(bundle, "clockwise")
    session = answerer.session(answerer.encode(recording(fps=30)))
    told = session.ask(asked)
    assert told.amount is not None
    assert session.ask("Error bars?").text == told.text
