"""An answer to what was not asked is declined; words new to a model are put into known ones."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
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
