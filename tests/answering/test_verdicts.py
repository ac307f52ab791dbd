"""Yes and no: what a verdict is on, and that it agrees with the motion told with it."""

from dataclasses import replace

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.hearing import MOVING_QUESTION
from geotlm_lm.answering.overruling import shares_of_the_claim
from geotlm_lm.conversation.retell import CAMERA
from geotlm_lm.conversation.signed_axes import CLOCKWISE_IS_POSITIVE
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording


@pytest.mark.parametrize(
    ("question", "text", "decided"),
    [
        ("rotation sense pls", "Clockwise, in the camera image.", "clockwise"),
        ("Is the thing slipping?", "No, it goes clockwise in the camera image.", "no"),
        ("Would it be spinning?", "Yes, it goes clockwise in the camera image.", "yes"),
        ("Is the right cap turning?", "Yes, it goes clockwise in the camera image.", "yes"),
    ],
)
def test_a_no_to_nothing_that_was_claimed_is_not_said(bundle, question, text, decided):
    denial = bundle.grammar.sentence(Slots("verify", Motion.DOWN, verdict=False))
    opened = bundle.grammar.sentence(Slots("direction", Motion.CLOCKWISE))
    answerer = answerer_saying(bundle, {"*": denial, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.decided) == (text, decided)


@pytest.mark.parametrize("question", ["Is it sliding left?", "is it sliding lefft?"])
def test_a_no_to_a_claim_stands_in_the_models_words(bundle, question):
    denial = bundle.grammar.sentence(Slots("verify", Motion.DOWN, verdict=False))
    answerer = answerer_saying(bundle, {"*": denial})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.told_by) == (denial, "model")


@pytest.mark.parametrize(
    ("question", "said", "text", "decided"),
    [
        (
            "Is the coin just resting there?",
            "Yes, it is pressing in.",
            "No, it is pressing in.",
            "no",
        ),
        (
            "Does it go left?",
            "No, it goes left in the camera image.",
            "Yes, it goes left in the camera image.",
            "yes",
        ),
        (
            "Is it spinning?",
            "Yes, left in the camera image.",
            "No, it goes left in the camera image.",
            "no",
        ),
        (
            "Is it not going right?",
            "It is: it goes left in the camera image.",
            "It is not: it goes left in the camera image.",
            "it is not",
        ),
        (
            "Why does it turn clockwise so slowly, and how fast?",
            "That holds: it goes left in the camera image.",
            "But no, it goes left in the camera image.",
            "it does not",
        ),
    ],
)
def test_a_verdict_that_denies_the_motion_told_with_it_is_put_right(
    bundle, question, said, text, decided
):
    opened = "It is pressing in." if "pressing" in text else "Left, in the camera image."
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: opened})
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    assert (answer.text, answer.decided, answer.told_by) == (text, decided, "rule")
    *told, streamed = answerer.stream(encoded, question)
    assert ("".join(told), streamed.text) == (text, text)


def test_a_verdict_on_a_claim_that_no_rule_reads_stands(bundle):
    answerer = answerer_saying(bundle, {"*": "Yes, it is pressing in."})
    answer = answerer.ask(answerer.encode(recording()), "Is it being squashed?")
    assert (answer.text, answer.told_by) == ("Yes, it is pressing in.", "model")


@pytest.mark.parametrize(
    "question",
    [
        "Is anything pressing on the gel?",
        "Is something pushing on the sensor?",
        "Is anything resting on the gel?",
    ],
)
def test_what_presses_or_rests_may_be_answered_by_a_contact(bundle, question):
    answerer = answerer_saying(bundle, {"*": "Yes, something is touching the gel."})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.kind, answer.told_by) == ("contact", "model")


@pytest.mark.parametrize(
    "passed_over",
    [
        "I cannot tell that from touch.",
        "Yes, something is touching the gel.",
        "Yes, it is moving.",
    ],
)
def test_a_claim_of_motion_in_new_words_is_not_passed_over(bundle, passed_over):
    said = {"*": passed_over, OPEN_QUESTION: "Up, in the camera image."}
    answerer = answerer_saying(bundle, said)
    encoded = answerer.encode(recording())
    question = "Is the cable slipping through my fingers?"
    answer = answerer.ask(encoded, question)
    assert answer.text.startswith("Yes, it goes up in the camera image")
    assert (answer.kind, answer.told_by) == ("verify", "rule")
    *told, streamed = answerer.stream(encoded, question)
    assert "".join(told) == streamed.text == answer.text
    assert answerer.ask(encoded, "Is the cable mine?").text == passed_over


@pytest.mark.parametrize(
    ("question", "felt", "decided"),
    [
        ("has it stopped?", Motion.STILL, "yes"),
        ("has it stopped?", Motion.NONE, "yes"),
        ("has it stopped?", Motion.CLOCKWISE, "no"),
        ("did it stop turning?", Motion.LEFT, "yes"),
        ("did it stop turning?", Motion.CLOCKWISE, "no"),
        ("is it no longer sliding left?", Motion.LEFT, "no"),
        ("is it no longer sliding left?", Motion.UP, "yes"),
        ("is it stationary?", Motion.UP, "no"),
        ("has it come to a stop?", Motion.STILL, "yes"),
        ("is the contact lost?", Motion.NONE, "yes"),
        ("did it lose contact?", Motion.RIGHT, "no"),
        ("is the contact lost?", Motion.RELEASE, "yes"),
        ("did it stop touching the gel?", Motion.STILL, "no"),
        ("did it stop touching the gel?", Motion.RELEASE, "yes"),
        ("is it at rest, no longer moving?", Motion.STILL, "yes"),
        ("is it at rest, no longer moving?", Motion.UP, "no"),
        ("is it turning without stopping?", Motion.CLOCKWISE, "yes"),
        ("did it slide without losing contact?", Motion.LEFT, "yes"),
        ("is the stop screw turning?", Motion.CLOCKWISE, "yes"),
        ("is it still sliding?", Motion.STILL, "no"),
        ("is it still sliding?", Motion.UP, "yes"),
        ("is there any slip?", Motion.CLOCKWISE, "no"),
        ("is it a pure rotation?", Motion.CLOCKWISE, "yes"),
    ],
)
@pytest.mark.parametrize("said", ["It is still: touching but not moving.", "Of the gel."])
def test_a_claim_is_judged_by_the_motion_told_openly(bundle, question, felt, decided, said):
    opened = bundle.grammar.sentence(Slots("direction", felt))
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.direction, answer.decided, answer.kind) == (felt, decided, "verify")


@pytest.mark.parametrize("verdict", [True, False])
def test_a_verdict_tells_no_other_motion_than_the_open_answer(bundle, verdict):
    said = bundle.grammar.sentence(Slots("verify", Motion.DOWN, verdict=verdict))
    opened = bundle.grammar.sentence(Slots("direction", Motion.CLOCKWISE))
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: opened})
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Is it sliding?")
    assert answer.text == "No, it goes clockwise in the camera image."
    *words, streamed = answerer.stream(encoded, "Is it sliding?")
    assert ("".join(words), streamed.decided) == (answer.text, "no")


def test_whether_it_still_moves_is_asked_as_whether_it_moves(bundle):
    said = {"*": "Yes, it is touching but not moving.", MOVING_QUESTION: "Yes, it is moving."}
    answerer = answerer_saying(bundle, said)
    answer = answerer.ask(answerer.encode(recording()), "Is it still moving?")
    assert (answer.text, answer.decided) == ("Yes, it is moving.", "yes")


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("Clockwise (A) or left (B)?", "Left, in the camera image, option B."),
        ("up (a), left (b), clockwise (c)", "Left, in the camera image, option B."),
        ("1) right 2) left", "Left, in the camera image, option 2."),
        ("A) right B) left", "Left, in the camera image, option B."),
    ],
)
@pytest.mark.parametrize("said", ["Left, option A.", "Yes, left in the camera image."])
def test_a_choice_names_the_option_that_holds_the_motion(bundle, question, text, said):
    opened = bundle.grammar.sentence(Slots("direction", Motion.LEFT))
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text == text


def test_two_ways_without_letters_are_no_claim(bundle):
    said = {"*": "Yes, left in the camera image.", OPEN_QUESTION: "Left, in the camera image."}
    answerer = answerer_saying(bundle, said)
    answer = answerer.ask(answerer.encode(recording()), "cw/ccw?")
    assert (answer.text, answer.decided) == ("Left, in the camera image.", "left")


@pytest.mark.parametrize(
    ("question", "sure"), [("Is it sliding?", 0.95), ("Is it sliding left?", 0.9)]
)
def test_a_claim_is_as_probable_as_the_motions_it_would_be_true_of(question, sure):
    shares = {"left": 0.9, "up": 0.05, "clockwise": 0.03, "still": 0.02}
    yes = Slots("verify", Motion.LEFT, verdict=True)
    found = shares_of_the_claim(yes, shares, question, CAMERA)
    assert found == pytest.approx({"yes": sure, "no": 1 - sure})
    assert shares_of_the_claim(replace(yes, verdict=False), shares, question, CAMERA) == {}
    assert shares_of_the_claim(yes, {"yes": 0.7, "no": 0.3}, question, CAMERA) == {}
    assert shares_of_the_claim(yes, shares, "Is it fine?", CAMERA) == {}


def test_an_open_question_about_an_approach_claims_none(bundle):
    opened = bundle.grammar.sentence(Slots("direction", Motion.CLOCKWISE))
    answerer = answerer_saying(bundle, {"*": opened, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), "Which way does the coin approach?")
    assert (answer.text, answer.decided) == (opened, "clockwise")


@pytest.mark.parametrize(
    ("question", "motion", "is_told"),
    [
        ("What is the sign of theta?", Motion.CLOCKWISE, True),
        ("Is the rotation angle negative?", Motion.COUNTERCLOCKWISE, True),
        ("Is the rotation angle negative?", Motion.LEFT, False),
        ("Is it turning clockwise?", Motion.CLOCKWISE, False),
    ],
)
def test_which_turn_is_positive_is_told_where_a_sign_is_asked_after(
    bundle, question, motion, is_told
):
    opened = bundle.grammar.sentence(Slots("direction", motion))
    answerer = answerer_saying(bundle, {"*": opened, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.direction is motion
    assert (CLOCKWISE_IS_POSITIVE in answer.notes) is is_told
