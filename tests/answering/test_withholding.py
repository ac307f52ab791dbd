"""The next likeliest answer, named beside a doubtful one."""

import pytest

from tests.answering.scripted import answerer_saying, recording


def test_a_doubtful_answer_comes_with_the_next_likeliest(bundle):
    answerer = answerer_saying(bundle, {"*": "It is pressing in."})
    answerer.bundle.speaker.likes = "Clockwise, in the camera image."
    answer = answerer.ask(answerer.encode(recording()), "Which way?")
    assert answer.abstained
    assert answer.notes[-1] == "Next likeliest, at 34%: clockwise."


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
