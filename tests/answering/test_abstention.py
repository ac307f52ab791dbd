"""The next likeliest answer, named beside a doubtful one."""

import numpy as np
import pytest

from tests.answering.scripted import answerer_saying, recording


def test_a_doubtful_answer_comes_with_the_next_likeliest(bundle):
    answerer = answerer_saying(bundle, {"*": "It is pressing in."})
    answerer.bundle.speaker.likes = "Clockwise, in the camera image."
    answer = answerer.ask(answerer.encode(recording()), "Which way?")
    assert answer.abstained
    assert answer.notes[-1] == "Next likeliest, at 34%: clockwise."


def test_another_answer_that_is_likelier_than_the_words_is_not_called_the_next(bundle):
    answerer = answerer_saying(bundle, {"*": "It is pressing in."})
    # The words are written, the answers weighed: here the words are one of nine unlikely ones.
    weighs = {one: -3.4 for one in answerer.bundle.grammar.options_for("direction")}
    weighs["Clockwise, in the camera image."] = -1.1
    answerer.bundle.speaker.score = lambda token, question, options: np.array(
        [weighs[one] for one in options]
    )
    answer = answerer.ask(answerer.encode(recording()), "Which way?")
    assert answer.text == "I cannot tell for sure, 5%: It is pressing in."
    assert answer.notes[-1] == "Likelier by the probabilities, at 53%: clockwise."


@pytest.mark.parametrize(
    ("question", "said", "temperature"),
    [
        ("Which way?", "It is pressing in.", 0.1),  # sure
        ("Which way?", "It is pressing in.", 1.0),  # the others are all as unlikely
        ("How far?", "No distance: it is pressing in.", 0.5),  # of six kinds
        ("What does it cost?", "I cannot tell that from touch.", 1.0),
    ],
)
def test_no_other_answer_is_named_where_none_stands_out(bundle, question, said, temperature):
    answerer = answerer_saying(bundle, {"*": said}, temperature=temperature)
    encoded = answerer.encode(recording())
    assert answerer.ask(encoded, question).notes == encoded.clip.notes
