"""A claim of a word or two is asked as a whole question."""

import pytest

from geotlm_lm.conversation.short_questions import in_full


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("turning?", "Is it turning?"),
        ("ok and spinning", "Is it turning?"),
        ("rotating: yes/no", "Is it turning?"),
        ("a rotation?", "Is it turning?"),
        ("sliding then?", "Is it sliding?"),
        ("slip == true?", "Is it slipping?"),
        ("query: slip", "Is it slipping?"),
        ("moving: true/false", "Is it moving?"),
        ("Up or not?", "Is it going up?"),
        ("left, yes or no", "Is it going left?"),
        ("Clockwise: true or false?", "Is it turning clockwise?"),
        ("pressing or not", "Is it pressing?"),
        ("Nothing or not?", "Is it nothing?"),
        ("left/right?", "left or right?"),
        ("up / down / left / right", "up or down or left or right?"),
    ],
)
def test_a_word_is_asked_as_a_question(text, asked):
    assert in_full(text) == asked


@pytest.mark.parametrize(
    "text",
    [
        "up?",
        "Is it turning or not?",
        "turning or sliding?",
        "the turning cap?",
        "touching or not?",
        "right or wrong?",
        "which way is it turning?",
        "turning left?",
        "no slip?",
    ],
)
def test_other_texts_stay_as_they_are(text):
    assert in_full(text) == text


def test_what_is_pressed_asks_for_a_press():
    assert in_full("pressed or not?") == "Is it pressing?"
