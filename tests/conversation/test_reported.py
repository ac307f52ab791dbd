"""A claim of somebody else is judged as if it were asked."""

import pytest

from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.reported import asked_of_report


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        (
            "My colleague claims it slid to the left. Is he right?",
            "Is it true that it slid to the left?",
        ),
        ("The log says it went right. Is that wrong?", "Is it false that it went right?"),
        ("I think it turns clockwise, am I right?", "Is it true that it turns clockwise?"),
        ("The bead should be at rest now. Is it?", "Is the bead at rest?"),
        ("It is supposed to slide right. Does it?", "Does it slide right?"),
        (
            "My colleague says it goes left but I say right. Who is right?",
            "Which way is it moving?",
        ),
    ],
)
def test_what_is_reported_is_asked(text, asked):
    assert asked_of_report(text) == asked


@pytest.mark.parametrize(
    "text",
    [
        "Is it going right?",
        "Who is right?",
        "He says it is red. Is he right?",
        "My colleague says it goes left.",
        "It slid to the left. Is that right?",
        "A: nothing, B: still. Which one is correct?",
        "left or up, which is right?",
    ],
)
def test_other_texts_report_nothing(text):
    assert asked_of_report(text) is None


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("She says it turns. Is she right?", "Does it turn?"),
        ("We think the nut rotates. Are we right?", "Does the nut rotate?"),
        ("He believes that it touches. Is he right?", "Is anything touching the gel?"),
        ("He says it moves. Is he right?", "Is it moving at all?"),
        ("She says it turns. Is she wrong?", "Is it false that it turns?"),
        ("It must have slipped. Has it?", "Has it slipped?"),
    ],
)
def test_claims_of_a_kind_and_of_contact_are_put_up_too(text, asked):
    assert asked_of_report(text).lower() == asked.lower()


def test_who_is_right_names_no_slide():
    assert motions_named("She says it turns. Is she right?") == set()
