"""What is touched is known by how people name it; nobody who holds it, and no measure, is."""

import pytest

from geotlm_lm.conversation.things import naming_nothing


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("has the cap turned?", "has _thing turned?"),
        ("is my bottle cap turning", "is _thing turning"),
        ("how far has this m8 hex nut turned?", "how far has _thing turned?"),
        ("did the cap's edge move?", "did _thing's edge move?"),
    ],
)
def test_a_thing_is_named_by_up_to_three_words(text, read):
    assert read in naming_nothing(text)


@pytest.mark.parametrize(
    "text",
    [
        "has the sensor turned?",
        "did my gripper slip?",
        "tell me the direction it turned",
        "is the contact lost?",
        "did the 2 turn?",
        "which way does it turn?",
    ],
)
def test_what_is_no_thing_stays_as_it_is(text):
    assert naming_nothing(text) == (text,)


def test_a_name_may_end_before_a_word_that_is_a_noun_too():
    read = naming_nothing("did the hex nut drop?")
    assert {"did _thing nut drop?", "did _thing drop?", "did _thing"} & set(read)
    assert "did _thing drop?" in read
