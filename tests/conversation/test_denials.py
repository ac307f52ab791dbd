"""A denial in other words is a "not"."""

import pytest

from geotlm_lm.conversation.denials import plainly_denied


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("Is it anything but a rotation?", "Is it not a rotation?"),
        ("is the cap doing anything but turning", "is the cap not turning"),
        ("everything but a slide?", "not a slide?"),
        ("Is it moving without turning?", "Is it moving but not turning?"),
        ("It can't be moving left, can it?", "It is not moving left, is it?"),
        ("My cap could not possibly be turning, could it?", "My cap is not turning, is it?"),
    ],
)
def test_a_not_stands_in_its_place(text, plain):
    assert plainly_denied(text) == plain


@pytest.mark.parametrize(
    "text", ["It can't be moved?", "Is anything moving?", "can it be left?", "It's not left."]
)
def test_other_texts_stay_as_they_are(text):
    assert plainly_denied(text) == text


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("Does it do anything but turn?", "Does it not turn?"),
        ("Does anything but the cap touch the gel?", "Does anything but the cap touch the gel?"),
        ("Is it anything but still?", "Is it moving?"),
    ],
)
def test_only_a_sentence_is_made_of_a_denial(text, plain):
    assert plainly_denied(text) == plain
