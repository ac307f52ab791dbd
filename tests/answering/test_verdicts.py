"""Yes and no: what a verdict is on, and that it agrees with the motion told with it."""

from dataclasses import replace

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.consistency_check import claim_probabilities
from geotlm_lm.answering.model_query import MOVING_QUESTION
from geotlm_lm.conversation.motion_answers import CAMERA
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording


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
    "passed_over",
    ["I cannot tell that from touch.", "Yes, something is touching the gel.", "Yes, it is moving."],
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
    ("question", "sure"), [("Is it sliding?", 0.95), ("Is it sliding left?", 0.9)]
)
def test_a_claim_is_as_probable_as_the_motions_it_would_be_true_of(question, sure):
    shares = {"left": 0.9, "up": 0.05, "clockwise": 0.03, "still": 0.02}
    yes = Slots("verify", Motion.LEFT, verdict=True)
    found = claim_probabilities(yes, shares, question, CAMERA)
    assert found == pytest.approx({"yes": sure, "no": 1 - sure})
    assert claim_probabilities(replace(yes, verdict=False), shares, question, CAMERA) == {}
    assert claim_probabilities(yes, {"yes": 0.7, "no": 0.3}, question, CAMERA) == {}
    assert claim_probabilities(yes, shares, "Is it fine?", CAMERA) == {}
