"""Yes and no: what a verdict is on, and that it agrees with the motion told with it."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, believed, feeling, recording


@pytest.mark.parametrize("question", ["Is it sliding left?", "is it sliding lefft?"])
def test_a_no_to_a_claim_stands_in_the_models_words(bundle, question):
    denial = bundle.grammar.sentence(Slots("verify", Motion.DOWN, verdict=False))
    answerer = answerer_saying(bundle, {"*": denial})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.told_by) == (denial, "model")


@pytest.mark.parametrize(
    ("question", "said", "begins", "decided"),
    [
        ("Is the coin just resting there?", "Yes, it is pressing in.", "No, it presses in", "no"),
        (
            "Does it go left?",
            "No, it goes left in the camera image.",
            "Yes, it slides left, about ",
            "yes",
        ),
        (
            "Is it spinning?",
            "Yes, left in the camera image.",
            "No, it does not turn; it slides left, about ",
            "no",
        ),
        (
            "Is it not going right?",
            "It is: it goes left in the camera image.",
            "It is not: it slides left, about ",
            "it is not",
        ),
        (
            "Why does it turn clockwise so slowly, and how fast?",
            "That holds: it goes left in the camera image.",
            "But no, it does not turn; it slides left, about ",
            "it does not",
        ),
    ],
)
def test_a_verdict_that_denies_what_is_felt_is_put_right(bundle, question, said, begins, decided):
    felt = believed("press" if "press" in begins else "left")
    answerer = answerer_saying(bundle, {"*": said}, belief=felt)
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    assert answer.text.startswith(begins)
    assert (answer.decided, answer.told_by) == (decided, "rule")
    *told, streamed = answerer.stream(encoded, question)
    assert ("".join(told), streamed.text) == (answer.text, answer.text)


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
    assert answer.text.startswith("Yes, it slides up, about ")
    assert (answer.kind, answer.told_by) == ("verify", "rule")
    *told, streamed = answerer.stream(encoded, question)
    assert "".join(told) == streamed.text == answer.text
    assert answerer.ask(encoded, "Is the cable mine?").text == passed_over


@pytest.mark.parametrize("verdict", [True, False])
def test_a_verdict_tells_no_other_motion_than_is_felt(bundle, verdict):
    said = bundle.grammar.sentence(Slots("verify", Motion.DOWN, verdict=verdict))
    answerer = answerer_saying(bundle, {"*": said}, belief=believed("clockwise"))
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Is it sliding?")
    assert answer.text.startswith("No, it does not slide; it turns clockwise, about 12 degrees")
    *words, streamed = answerer.stream(encoded, "Is it sliding?")
    assert ("".join(words), streamed.decided) == (answer.text, "no")


def test_whether_it_still_moves_is_asked_as_whether_it_moves(bundle):
    said = {"*": "Yes, it is touching but not moving."}
    answerer = answerer_saying(bundle, said, belief=believed("left"))
    answer = answerer.ask(answerer.encode(recording()), "Is it still moving?")
    assert (answer.text, answer.decided) == ("Yes, it is moving.", "yes")


@pytest.mark.parametrize(
    ("question", "decided", "begins"),
    [
        ("Is it turning?", "yes", "Yes, it turns clockwise, about 12 degrees, in"),
        ("Is it sliding?", "yes", "Yes, it slides left, about "),
        ("Is it turning counterclockwise?", "no", "No, it turns clockwise, about 12 degrees, in"),
        ("Is it turning and sliding?", "yes", "Yes, it turns clockwise, about 12 degrees, and sl"),
        ("Is it turning and pressing in?", "no", "No, it turns clockwise, about 12 degrees, in"),
        ("Is it pressing in?", "no", "No, it does not press in or lift off; it turns clockwise,"),
        ("Is it stationary?", "no", "No, it turns clockwise, about 12 degrees, and slides left"),
    ],
)
def test_a_claim_is_judged_by_its_component(bundle, question, decided, begins):
    answerer = feeling(bundle, "clockwise", "left")
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(begins)
    assert (answer.decided, answer.abstained) == (decided, False)


def test_a_no_is_as_sure_as_the_least_sure_thing_it_says(bundle):
    belief = believed("left", share=0.7)
    answerer = answerer_saying(bundle, {"*": "A slide."}, belief=belief)
    answer = answerer.ask(answerer.encode(recording()), "Is it turning clockwise?")
    assert answer.decided == "no"
    assert answer.options == pytest.approx({"yes": 0.0, "no": 1.0})
    assert answer.confidence == pytest.approx(0.7)
