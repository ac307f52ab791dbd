"""A query and its line of words are one and the same."""

import pytest
from hypothesis import given, settings

from geotlm_lm.query.quantities import LARGEST, quantities
from geotlm_lm.query.text import next_words, read, write
from geotlm_lm.query.types import Quantity, filled
from geotlm_lm.query.words import Malformed
from tests.query.strategies import queries, query_texts


@given(queries)
@settings(max_examples=200, deadline=None)
def test_what_is_written_is_read_back(query):
    assert read(write(query)) == query


@given(query_texts())
@settings(max_examples=100, deadline=None)
def test_a_canonical_line_can_be_emitted_word_by_word(text):
    words = write(read(text)).split()
    assert all(word in next_words(words[:at], 3) for at, word in enumerate(words))


@given(queries)
@settings(max_examples=100, deadline=None)
def test_a_filled_query_is_read_back_with_its_numbers(query):
    found = filled(query, (Quantity(12.5, "deg"), Quantity(0.06, "mm/px"), Quantity(-3.0)))
    assert read(write(found)) == found


def test_a_number_is_only_offered_where_the_question_has_one():
    assert ">" in next_words(["claim", "turn"], 1)
    assert ">" not in next_words(["claim", "turn"], 0)
    assert "scale" not in next_words(["fact"], 0)


def test_what_is_no_query_is_refused_in_one_sentence():
    with pytest.raises(Malformed) as refused:
        read("claim sideways")
    assert str(refused.value).startswith("A query had 'sideways' after 'claim', expected one of ")


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("half a turn", 0.5, "turn"),
        ("one and a half degrees", 1.5, "deg"),
        ("two hundred and five degrees", 205, "deg"),
        ("twenty-five degrees", 25, "deg"),
        ("two point five mm", 2.5, "mm"),
        ("1 1/2 degrees", 1.5, "deg"),
        ("1,5 mm", 1.5, "mm"),
        ("1,200 px", 1200, "px"),
        ("10 degrees a second", 10, "deg/s"),
        ("17 rpm", 17, "turn/min"),
        ("at 25 fps", 25, "frame/s"),
        ("200 μm", 200, "um"),
        ("more than -20 degrees", -20, "deg"),
        ("5 mm in each frame", 5, "mm/frame"),
        ("5 mm in the image", 5, "mm"),
        ("5 mm. The image is mirrored", 5, "mm"),
        ("10 deg. per second", 10, "deg/s"),
        ("20 px to the mm", 20, "px/mm"),
        ("0.06mm/px", 0.06, "mm/px"),
    ],
)
def test_a_quantity_is_found_with_its_unit(text, value, unit):
    assert quantities(text) == (Quantity(pytest.approx(value), unit),)


@pytest.mark.parametrize("text", ["Which one?", "the 1st clip", "a quarter", "bolt B2", "a few mm"])
def test_what_is_no_quantity_is_left(text):
    assert quantities(text) == ()


NINES = "9" * 5000


@pytest.mark.parametrize(
    ("text", "value"),
    [
        (f"{NINES} degrees", LARGEST),
        (f"{NINES}/{NINES} degrees", 1),
        (f"1 {NINES}/4 degrees", 1 + LARGEST / 4),
        (f"1 1/{NINES} degrees", 1),
        ("a thousand " + "thousand " * 200 + "degrees", LARGEST),
    ],
)
def test_a_number_of_any_length_is_one_quantity(text, value):
    assert quantities(text) == (Quantity(pytest.approx(value), "deg"),)


def test_two_ends_of_a_range_are_two_quantities():
    found = quantities("between ten and 20 degrees, or 5-10 mm")
    assert [one.value for one in found] == [10, 20, 5, 10]
