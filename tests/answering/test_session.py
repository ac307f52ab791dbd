"""A conversation keeps its frame and its answers; doubt changes neither."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from tests.answering.scripted import answerer_saying, feeling, measuring, recording


@pytest.fixture
def session(bundle):
    answerer = feeling(bundle, "clockwise")
    return answerer.session(answerer.encode(recording()))


@pytest.mark.parametrize(
    "doubt",
    [
        "Are you sure?",
        "are you really sure about that",
        "Really?",
        "I think you are wrong.",
        "No, it is counterclockwise!",
        "No.",
        "that's wrong",
        "how sure are you?",
        "r u sure??",
        "check again",
        "You are wrong, look again!",
        "what about the other way?",
        "isn't it the opposite direction?",
        "Is this right?",
        "correct?",
        "100%?",
        "more than 90% sure?",
    ],
)
def test_doubt_repeats_the_answer_with_its_probability_and_never_turns_it(session, doubt):
    first = session.ask("Which way does it turn?")
    again = session.ask(doubt)
    assert again.direction == first.direction == Motion.CLOCKWISE
    assert again.confidence == first.confidence
    assert again.text == (
        "I am not sure of it, but it is the likeliest, 55%: Clockwise, in the camera image."
    )


def test_doubt_upon_doubt_says_the_same(session):
    session.ask("Which way?")
    texts = {session.ask(doubt).text for doubt in ("Really?", "Are you sure?", "no way")}
    assert len(texts) == 1


def test_doubt_runs_no_model(session):
    session.ask("Which way?")
    heard = list(session.answerer.bundle.speaker.heard)
    session.ask("Are you sure?")
    assert session.answerer.bundle.speaker.heard == heard


def test_a_refusal_is_repeated_as_it_is(session):
    refusal = session.ask("By how much?")
    assert session.ask("Really?") == refusal


def test_the_first_question_can_be_a_doubt(session):
    assert session.ask("How sure are you?").text.startswith("My confidence is low: 55% that")


def test_an_answer_is_said_again(session):
    first = session.ask("Which way?")
    assert session.ask("Say that again?") == first


def test_facts_last_and_change_what_is_told(session):
    session.ask("I look from the object's side.")
    assert session.frame == FrameSpec(viewpoint="object")
    assert session.ask("Which way?").text == "Counterclockwise, seen from the object's side."
    session.ask("Left-hand thread, touched at the head.")
    assert session.ask("Is it tightening?").text.startswith(
        "It loosens: counterclockwise seen from"
    )
    session.ask("reset the frame")
    assert session.ask("Which way?").text == "Clockwise, in the camera image."


def test_the_object_is_asked_the_same_as_the_sensor(session):
    session.ask("Which way does the sensor move?")
    told = session.ask("And the object?")
    assert told.text == "Clockwise, in the camera image."
    assert session.ask("No, I meant the sensor.").text.startswith("The sensor goes counterclock")


def test_now_asks_the_question_before_in_the_new_frame(session):
    session.ask("The image is mirrored. Does it turn clockwise?")
    session.ask("The image is not mirrored.")
    assert session.ask("And now?").decided == "yes"
    session.ask("I look from the object's side.")
    told = session.ask("and now?")
    assert (told.decided, told.direction) == ("no", Motion.COUNTERCLOCKWISE)


def test_now_asks_the_question_before_of_a_new_clip(session):
    first = session.ask("Does it turn clockwise?")
    session.add_clip(session.answerer.encode(recording(seed=2)))
    assert session.ask("And now?").decided == first.decided == "yes"


def test_now_alone_asks_nothing(session):
    assert session.ask("and now?").abstained


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


def test_a_viewpoint_asked_for_once_does_not_last(session):
    once = session.ask("Seen from the object's side, which way?")
    assert once.direction is Motion.COUNTERCLOCKWISE
    assert session.ask("Which way?").direction is Motion.CLOCKWISE


def test_an_image_turned_in_thought_is_turned_for_one_question(bundle):
    answerer = feeling(bundle, "left")
    session = answerer.session(answerer.encode(recording()))
    once = session.ask("If I turned the picture upside down, which way?")
    assert once.text == "Right, in the camera image turned by 180 degrees."
    assert (once.direction, session.frame) == (Motion.RIGHT, FrameSpec())
    assert session.ask("Which way?").text == "Left, in the camera image."


def test_a_turned_image_lasts_until_it_is_said_to_be_upright(bundle):
    answerer = feeling(bundle, "left")
    session = answerer.session(answerer.encode(recording()))
    noted = session.ask("The camera is rotated 90 degrees to the left.")
    assert noted.text.startswith(
        "Noted: camera image turned back by 90 degrees counterclockwise, looking out of the sensor"
    )
    assert session.ask("Which way?").direction is Motion.DOWN
    session.ask("The image is upright.")
    assert session.ask("Which way?").text == "Left, in the camera image."


def test_a_correction_that_lacks_the_sense_of_a_turn_is_asked_for_it(session):
    session.ask("Which way?")
    assert session.ask("No, the image is rotated by 90 degrees.").text.startswith(
        "I cannot tell a direction without the way it is turned"
    )


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
    answerer = feeling(bundle, "clockwise", temperature=0.1)
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


def test_a_trained_model_hears_what_is_asked_and_then_the_open_question(bundle):
    said = {"*": "Played backwards from: left in the camera image."}
    answerer = answerer_saying(bundle, said)
    session = answerer.session(answerer.encode(recording()))
    assert session.ask("And played backwards?").direction is Motion.RIGHT
    assert answerer.bundle.speaker.heard == ["And played backwards?", OPEN_QUESTION]


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        ("Is it likely that it turns clockwise?", "The probability of that is 55%: it goes clock"),
        ("What is the probability that it slips?", "The probability of that is 20%: it goes clock"),
        ("How sure are you that it goes left?", "The probability of that is 5%: it goes clockwise"),
        ("Are you certain about the rotation?", "The probability of that is 60%: it goes clock"),
    ],
)
def test_how_likely_a_motion_is_is_asked_of_that_motion(session, asked, text):
    session.ask("Is anything touching?")
    assert session.ask(asked).text.startswith(text)


def test_a_probability_is_said_again_as_it_is(session):
    first = session.ask("Is it likely that it slips?")
    assert session.ask("Are you sure?") == first


@pytest.mark.parametrize(
    "doubt", ["What is the probability?", "How likely is that?", "Are you sure it is not turning?"]
)
def test_how_likely_without_a_motion_is_of_the_answer_before(session, doubt):
    session.ask("Which way?")
    assert session.ask(doubt).text.endswith("likeliest, 55%: Clockwise, in the camera image.")


@pytest.mark.parametrize("again", ["Are you sure?", "Say that again?", "Really?"])
def test_an_answer_said_again_after_another_clip_names_the_clip_before(session, again):
    session.ask("Which way?")
    session.add_clip(session.answerer.encode(recording(seed=2)))
    said = session.ask(again).text
    assert said.endswith("Of the clip before: Clockwise, in the camera image.")
    session.ask("Which way?")
    assert "before" not in session.ask(again).text


def test_a_bare_number_is_judged_in_the_unit_of_the_amount_told_last(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    session = answerer.session(answerer.encode(recording()))
    session.ask("how far?")
    assert session.ask("more than 20?").decided == "no"
    assert session.ask("and more than 5?").decided == "yes"


def test_a_thread_supposed_in_one_question_is_forgotten_after_it(session):
    session.ask("left-hand thread, touched at the head")
    assert session.ask("is it being opened?").text.startswith("It loosens: ")
    assert session.ask("and with a right-hand thread?").text.startswith("It tightens: ")
    assert session.ask("in or out?").text.startswith("It loosens: ")


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
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg")
    session = answerer.session(answerer.encode(recording(fps=30)))
    told = session.ask(asked)
    assert told.amount is not None
    assert session.ask("Error bars?").text == told.text


@pytest.mark.parametrize("asked", ["Seen from the object's side, which way?", "And the sensor?"])
def test_what_else_it_may_be_is_told_as_the_answer_before(session, asked):
    told = session.ask(asked)
    assert told.direction == Motion.COUNTERCLOCKWISE
    else_ = session.ask("What else could it be?")
    assert else_.text.startswith(told.text)
    assert session.ask("Which way?").direction == Motion.CLOCKWISE
    assert session.ask("What else?").direction == Motion.CLOCKWISE
