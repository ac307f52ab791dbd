"""A wording the model takes for another kind than its words tell is answered as the words tell."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.hearing import AMOUNT_QUESTION, EVIDENCE_QUESTION, MOVING_QUESTION
from geotlm_lm.conversation.kinds import is_ruled_out
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording

CLOCKWISE_EVIDENCE = load_templates().grammar().sentence(Slots("evidence", Motion.CLOCKWISE))


@pytest.mark.parametrize(
    ("question", "said", "text"),
    [
        # Derived from the motion, which the open question gives.
        ("And mirrored?", "Left, in the camera image.", "Right, in the camera image, if the clip"),
        ("Does it come loose?", "Yes, left in the camera image.", "Neither tighter nor looser: "),
        # Asked again in words the model knows.
        ("What makes you think so?", "I cannot tell that from touch.", "The upper half goes right"),
        ("Did it budge?", "I cannot tell that from touch.", "Yes, it is moving."),
        ("Did it budge?", "Yes, something is touching the gel.", "Yes, it is moving."),
        # What touch cannot tell, whatever the model makes of it.
        ("Steel or brass?", "A rotation.", "I cannot tell that from touch."),
        ("Any scratches on it?", "Yes, something is touching the gel.", "I cannot tell that from"),
        # The likeliest answer of a kind that the words do not rule out.
        (
            "What does the camera see?",
            "Played backwards from: left in the camera image.",
            "Left, in the came",
        ),
    ],
)
def test_where_words_and_model_disagree_on_what_is_asked_the_words_count(
    bundle, question, said, text
):
    known = {
        OPEN_QUESTION: "Left, in the camera image.",
        EVIDENCE_QUESTION: CLOCKWISE_EVIDENCE,
        MOVING_QUESTION: "Yes, it is moving.",
    }
    answerer = answerer_saying(bundle, known | {question: said}, temperature=0.1)
    answerer.bundle.speaker.likes = "Left, in the camera image."
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(text)
    assert answer.told_by == "rule"


def test_an_amount_in_new_words_is_asked_for_again_in_words_the_model_knows(bundle):
    known = {
        "*": "I cannot tell that from touch.",
        OPEN_QUESTION: "Clockwise, in the camera image.",
        AMOUNT_QUESTION: "An amount of turning, as measured.",
    }
    answerer = answerer_saying(bundle, known, temperature=0.1)
    answer = answerer.ask(answerer.encode(recording()), "How many degrees, about?")
    assert answer.text.startswith("About 13 degrees of turning")
    assert answer.told_by == "rule"


@pytest.mark.parametrize(
    "question",
    [
        "Which way does it move across the surface of the gel?",
        "Which way?",
        "What direction is it?",
    ],
)
def test_who_surely_asks_which_way_is_told_more_than_the_kind_of_motion(bundle, question):
    said = {question: "A rotation.", OPEN_QUESTION: "Clockwise, in the camera image."}
    answerer = answerer_saying(bundle, said, temperature=0.1)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.decided) == ("Clockwise, in the camera image.", "clockwise")


def test_words_of_several_clips_need_the_models_word_too(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    asked = "In order to grip it: which way does it go?"
    answer = answerer.ask(answerer.encode(recording()), asked)
    assert (answer.text, answer.told_by) == ("Left, in the camera image.", "model")


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_next_to_no_question_of_the_templates_is_taken_for_another_kind(wordings):
    label = MotionLabel(Motion.CLOCKWISE, rotation_deg=12.0)
    asked = [
        one
        for seed in range(50)
        for one in questions_for(label, generator_for(seed, "by words"), wordings=wordings)
    ]
    ruled_out = [one.question for one in asked if is_ruled_out(one.question, one.slots.kind)]
    assert len(ruled_out) <= 0.002 * len(asked), ruled_out
