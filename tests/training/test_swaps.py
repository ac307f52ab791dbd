"""Words exchanged together with their meaning leave a question that means what its program says."""

import random

import pytest

from geotlm_lm.query.lines import normal, read, write
from geotlm_lm.query.quantities import quantities
from geotlm_lm.training.grammar import Pair, corpus
from geotlm_lm.training.swaps import swaps


def _all_of(text, query, draws=60):
    """Return what a question may become, as (text, query)."""
    pair = Pair(text, query, ("own",))
    made = (swaps().exchanged(random.Random(seed), pair, 1.0) for seed in range(draws))
    return {(each.text, each.query) for each in made}


def test_a_way_takes_the_place_of_another_in_text_and_program():
    made = _all_of("Did it slide Left, and then right?", "and left right")
    assert ("Did it slide Up, and then down?", "and up down") in made
    assert all(len(set(query.split())) == 3 for _, query in made)


@pytest.mark.parametrize(
    ("text", "query", "other"),
    [
        ("How far is the first turn?", "within first turn-events amount turn", "last slide"),
        ("Is it over 10 degrees?", "> amount turn #1", "less"),
        ("In radians, please", "unit rad amount turn", "arcminutes"),
        ("it slid before 2 s", "before begin first slide-events t #1", "after"),
    ],
)  # fmt: skip
def test_what_is_exchanged_reads_as_it_is_written(text, query, other):
    made = _all_of(text, query)
    assert len(made) > 1
    assert not any(other in new for new, line in made if line == query)


@pytest.mark.parametrize(
    ("text", "query", "kept"),
    [
        ("It turned, right?", "turn", "right"),  # no way is meant
        ("Left-hand thread on the head?", "fact thread left ; fact side head ; tighten", "Left"),
        ("By more than 10 px, the slide?", "> amount slide #1", "slide"),
        ("print RIGHT if it goes right", "choose @1 right | other", "RIGHT"),
    ],
)
def test_a_word_that_means_something_else_stays(text, query, kept):
    assert all(kept in new for new, _ in _all_of(text, query))


def test_numbers_and_copied_words_of_labelled_questions_stay_what_they_are():
    rng, changed = random.Random(4), 0
    for pair in rng.sample(corpus("train"), 400):
        new = swaps().exchanged(rng, pair, 1.0)
        assert quantities(new.text) == quantities(pair.text)
        if new != pair:
            assert write(normal(read(new.query))) == new.query
            changed += 1
    assert changed > 100
