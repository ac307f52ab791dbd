"""An amount is of the turn or the slide that the open question is answered with."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.model_query import AMOUNT_QUESTION, ModelReply
from geotlm_lm.answering.single_direction import open_answer_motion
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording

SLIDING = "An amount of sliding, as measured."


def answerer_torn(bundle, opened, said=SLIDING):
    """An answerer whose open answer is `opened` and which says `said` of any amount."""
    opened = bundle.grammar.sentence(Slots("direction", opened))
    return answerer_saying(bundle, {"*": said, OPEN_QUESTION: opened}, temperature=0.1)


@pytest.mark.parametrize("question", [AMOUNT_QUESTION, "How far?", "0.1 mm per pixel. How far?"])
@pytest.mark.parametrize("said", [SLIDING, "No distance: it is lifting off."])
def test_what_is_told_to_turn_is_told_in_degrees(bundle, question, said):
    answerer = answerer_torn(bundle, Motion.CLOCKWISE, said)
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    assert answer.text.startswith("About 13 degrees of turning")
    *words, streamed = answerer.stream(encoded, question)
    assert ("".join(words), streamed.text) == (answer.text, answer.text)


@pytest.mark.parametrize("motion", [Motion.PRESS, Motion.STILL])
def test_where_the_open_answer_goes_no_way_the_amounts_own_words_count(bundle, motion):
    answerer = answerer_torn(bundle, motion)
    answer = answerer.ask(answerer.encode(recording()), AMOUNT_QUESTION)
    assert answer.amount.unit == "px"


def test_a_claim_is_judged_in_the_unit_of_the_open_answer(bundle):
    answerer = answerer_torn(bundle, Motion.CLOCKWISE)
    answer = answerer.ask(answerer.encode(recording()), "Did it turn 12 degrees?")
    assert (answer.decided, answer.amount.unit) == ("yes", "deg")


def test_of_two_clips_the_amounts_are_of_the_motions_that_are_told(bundle):
    answerer = answerer_torn(bundle, Motion.CLOCKWISE)
    pair = [answerer.encode(recording(seed=seed)) for seed in (1, 2)]
    said = answerer.compare(*pair, "Which one goes further?")
    assert said.text.endswith(" deg.")


@pytest.mark.parametrize(
    ("opened", "motion"),
    [
        (ModelReply(Slots("direction", Motion.LEFT), "", {"left": 0.9}), Motion.LEFT),
        (ModelReply(Slots("direction", Motion.LEFT), "", {"left": 0.4, "up": 0.6}), None),
        (ModelReply(Slots("direction", Motion.PRESS), "", {"press": 0.9}), None),
        (ModelReply(Slots("verify", Motion.LEFT, verdict=True), "", {"yes": 0.9}), None),
        (ModelReply(None, "", {}), None),
    ],
)
def test_a_turn_or_a_slide_is_told_where_the_open_answer_is_no_guess(opened, motion):
    assert open_answer_motion(opened) is motion
