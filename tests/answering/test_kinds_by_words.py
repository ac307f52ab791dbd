"""A wording the model takes for another kind than its words tell is answered as the words tell."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.model_query import EVIDENCE_QUESTION
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording

LEFT_EVIDENCE = load_templates().grammar().sentence(Slots("evidence", Motion.LEFT))


@pytest.mark.parametrize(
    ("question", "said", "text"),
    [
        # Derived from the motion, which the open question gives.
        ("And mirrored?", "Left, in the camera image.", "It slides right, about "),
        ("Does it come loose?", "Yes, left in the camera image.", "Neither tighter nor looser: "),
        # Asked again in words the model knows.
        (
            "What makes you think so?",
            "I cannot tell that from touch.",
            "Both halves go left",
        ),
        ("Did it budge?", "I cannot tell that from touch.", "Yes, it is moving."),
        ("Did it budge?", "Yes, something is touching the gel.", "Yes, it is moving."),
        # What touch cannot tell, whatever the model makes of it.
        ("Steel or brass?", "A rotation.", "I cannot tell that from touch."),
        ("Any scratches on it?", "Yes, something is touching the gel.", "I cannot tell that from"),
        # The likeliest answer of a kind that the words do not rule out.
        (
            "What does the camera see?",
            "Played backwards from: left in the camera image.",
            "It slides left, about",
        ),
    ],
)
def test_where_words_and_model_disagree_on_what_is_asked_the_words_count(
    bundle, question, said, text
):
    known = {OPEN_QUESTION: "Left, in the camera image.", EVIDENCE_QUESTION: LEFT_EVIDENCE}
    answerer = answerer_saying(bundle, known | {question: said})
    answerer.bundle.speaker.likes = "Left, in the camera image."
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(text)
    assert answer.told_by == "rule"
