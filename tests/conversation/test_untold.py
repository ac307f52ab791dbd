"""What is asked and never told is declined, and the place of the contact understood."""

import pytest

from geotlm_lm.conversation.untold import asks_place, untold


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("When does it start to move?", "watch"),
        ("At what frame does the rotation begin?", "watch"),
        ("how deep is the indentation?", "depth"),
        ("In which direction is the force?", "force"),
        ("Is the rotation about the z axis positive?", "axis"),
        ("help", "Ask how"),
        ("thanks!", "Ask how"),
        ("What can you do?", "Ask how"),
    ],
)
def test_what_is_never_told_is_declined_with_what_is(text, word):
    assert word in untold(text)


@pytest.mark.parametrize(
    "text",
    ["Which way?", "When did it start to turn left?", "Does it help to turn it?", "stop it?"]
    + [
        "When touched, which way does it move?",
        "Is pressure increasing?",
        "Under pressure, where?",
    ],
)
def test_other_questions_are_left_to_the_model(text):
    assert untold(text) is None


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ("Where is the contact?", True),
        ("is the contact at the top or the bottom?", True),
        ("where does the cap touch?", True),
        ("where is it going?", False),
        ("where is the object moving?", False),
        ("which way does the contact point move?", False),
        ("is the contact at rest?", False),
        ("is the contact on the move?", False),
        ("is the contact area getting larger?", False),
        ("is there contact?", False),
    ],
)
def test_who_asks_for_the_place_of_the_contact_is_understood(text, asks):
    assert asks_place(text) is asks
