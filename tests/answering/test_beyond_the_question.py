"""An answer to what was not asked is declined; words new to a model are put into known ones."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.conversation.future import NOT_TO_COME
from geotlm_lm.conversation.known_words import SLIP_IS_A_SLIDE
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording

TOUCHING, MOVING = "Yes, something is touching the gel.", "Yes, it is moving."
DECLINED = "I cannot tell that from touch."
LEFT = "Yes, left in the camera image."


@pytest.mark.parametrize(
    ("question", "said"),
    [
        ("Is there a crack in the surface?", TOUCHING),
        ("Are you a robot?", TOUCHING),
        ("twice that?", TOUCHING),
        ("Is it melting?", MOVING),
        ("Is there a lot of friction?", MOVING),
        ("Is the left finger's sensor recording?", LEFT),
        ("Is the camera on?", LEFT),
        ("Are the right jaw's cables fine?", LEFT),
    ],
)
def test_an_answer_to_another_question_is_declined(bundle, question, said):
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: "Left, in the camera image."})
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    assert (answer.text, answer.kind, answer.abstained) == (DECLINED, "refusal", True)
    *told, streamed = answerer.stream(encoded, question)
    assert ("".join(told), streamed.text) == (DECLINED, DECLINED)


@pytest.mark.parametrize(
    ("question", "said"),
    [
        ("Is there an object on the gel?", TOUCHING),
        ("Did you bump into something?", TOUCHING),
        ("Is something going on?", MOVING),
        ("Does it wind its way along?", LEFT),
    ],
)
def test_an_answer_to_what_was_asked_stands(bundle, question, said):
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: "Left, in the camera image."})
    assert answerer.ask(answerer.encode(recording()), question).text == said


@pytest.mark.parametrize("question", ["up?", "down?"])
def test_a_motion_named_alone_is_a_claim_of_it(bundle, question):
    said = {"*": DECLINED, OPEN_QUESTION: "Up, in the camera image."}
    answerer = answerer_saying(bundle, said)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.decided == ("yes" if question == "up?" else "no")


def test_what_is_being_pressed_is_told_of_contact_and_of_motion(bundle):
    said = {
        "*": bundle.grammar.sentence(Slots("verify", Motion.CLOCKWISE, verdict=False)),
        "Is anything touching the gel?": TOUCHING,
        OPEN_QUESTION: "Clockwise, in the camera image.",
    }
    answerer = answerer_saying(bundle, said)
    answer = answerer.ask(answerer.encode(recording()), "Is it being pressed against the gel?")
    assert answer.text == f"{TOUCHING} No, it goes clockwise in the camera image."


@pytest.mark.parametrize(
    ("question", "felt", "is_noted"),
    [
        ("any slip?", Motion.CLOCKWISE, True),
        ("Is it sliding?", Motion.CLOCKWISE, False),
        ("any slip?", Motion.LEFT, False),
    ],
)
def test_what_slip_is_taken_for_is_said_of_a_turn(bundle, question, felt, is_noted):
    opened = bundle.grammar.sentence(Slots("direction", felt))
    answerer = answerer_saying(bundle, {"*": MOVING, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.decided == ("yes" if felt is Motion.LEFT else "no")
    assert (SLIP_IS_A_SLIDE in answer.notes) is is_noted


def test_in_or_out_is_told_of_a_thread_that_is_known(bundle):
    said = {"*": DECLINED, OPEN_QUESTION: "Clockwise, in the camera image."}
    answerer = answerer_saying(bundle, said)
    encoded = answerer.encode(recording())
    frame = FrameSpec(thread="right", contact_side="head")
    assert answerer.ask(encoded, "in or out?", frame=frame).text.startswith("It tightens: ")
    assert answerer.ask(encoded, "in or out?").text == DECLINED
    unknown = answerer.ask(encoded, "Is the jar being opened?")
    assert unknown.text.startswith("I cannot tell tightening from loosening: tell me which side")


def test_what_comes_next_is_declined_and_what_is_supposed_is_not(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    encoded = answerer.encode(recording())
    assert answerer.ask(encoded, "Will it slip?").text == NOT_TO_COME
    assert answerer.ask(encoded, "Won\u2019t it slip?").text == NOT_TO_COME
    supposed = answerer.ask(encoded, "The image is mirrored. Which way will it go?")
    assert supposed.text.startswith("Right")
    upside_down = answerer.ask(encoded, "If the camera is upside down, which way will it go?")
    assert upside_down.text.startswith("Right")
    both = answerer.ask(encoded, "Which way does it go and will it slip?")
    assert both.text == f"Left, in the camera image. {NOT_TO_COME}"
