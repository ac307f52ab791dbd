"""A greeting, an excuse or a radio's "over" asks nothing."""

import pytest

from geotlm_lm.conversation.courtesies import without_courtesies
from geotlm_lm.conversation.untold import untold


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("Sorry to bother you, but is it moving by any chance?", "is it moving?"),
        ("Hi there! which way?", "which way?"),
        ("Thanks! One more thing: how far?", "how far?"),
        ("so um which way is the uh cap turning", "so which way is the cap turning"),
        ("is it sliding question mark", "is it sliding?"),
        ("copy, say direction of turn, over", "say direction of turn"),
        ("Good morning, is it still?", "is it still?"),
        ("slipping yes no", "slipping, yes or no"),
    ],
)
def test_what_stands_around_a_question_is_left_out(text, rest):
    assert without_courtesies(text) == rest


@pytest.mark.parametrize(
    "text", ["thanks", "Hello!", "um", "did it flip over?", "turn it over", "Hit it?", "Which way?"]
)
def test_other_texts_stay_as_they_are(text):
    assert without_courtesies(text) == text


@pytest.mark.parametrize(
    "text", ["Hi there", "Thanks a lot!", "Thank you very much!", "Copy that", "Hello, good day."]
)
def test_nothing_but_courtesies_stays_and_is_talk(text):
    assert without_courtesies(text) == text
    assert untold(text) is not None
