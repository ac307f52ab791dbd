"""Numbers as they are written."""

import re

import pytest

from geotlm_lm.conversation.number_words import NUMBER, number


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12.0),
        (".5", 0.5),
        ("-3", -3.0),
        ("1,5", 1.5),
        ("1,200", 1200.0),
        ("3/4", 0.75),
        ("1 1/2", 1.5),
        ("ninety", 90.0),
        ("twenty-five", 25.0),
        ("a hundred", 100.0),
        ("two hundred and five", 205.0),
        ("a thousand two hundred", 1200.0),
        ("two point five", 2.5),
        ("half a", 0.5),
        ("three quarters of a", 0.75),
        ("one and a half", 1.5),
        ("a single", 1.0),
        ("five ten", None),
        ("ten five", None),
        ("1/0", None),
    ],
)
def test_a_number_is_read_in_digits_and_in_words(text, value):
    assert re.fullmatch(f"-?(?:{NUMBER})", text)
    assert number(text) == value
