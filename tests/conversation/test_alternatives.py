"""What else a motion may be, by the words that ask for it."""

import pytest

from geotlm_lm.conversation.alternatives import asks_alternatives


@pytest.mark.parametrize(
    "question",
    [
        "What else could it be?",
        "what other motion might it be",
        "second guess?",
        "And what is the second most likely?",
        "the next likeliest answer, please",
        "Any alternatives?",
        "What are the probabilities?",
        "show all probabilities of each motion",
        "List the options with probabilities",
        "Rank the motions by probability",
        "top 3",
    ],
)
def test_the_odds_are_asked_for_in_many_words(question):
    assert asks_alternatives(question)


@pytest.mark.parametrize(
    "question",
    [
        "What is the probability that it turns?",
        "second?",
        "the next one",
        "The second one?",
        "Is the second clip faster?",
        "What else touches the gel?",
        "What could it cost?",
        "What comes next?",
        "List the motions.",
    ],
)
def test_one_probability_a_clip_or_a_thing_are_something_else(question):
    assert not asks_alternatives(question)
