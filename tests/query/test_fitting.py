"""Numbers stand where their unit lets them: what is meant is never left out."""

from itertools import islice

import pytest

from geotlm_lm.query.facts import mm_per_px
from geotlm_lm.query.fitting import fitting
from geotlm_lm.query.grammar import corpus, grammar
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.text import next_words


@pytest.mark.parametrize(
    ("text", "prefix", "words"),
    [
        ("1 pixel is 0.04 mm wide", "fact scale", {"#2"}),
        ("below 0.2 mm? It turned 4 degrees", "claim turn <", {"#2"}),
        ("after 3 s, more than 2 px?", "from", {"#1"}),
        ("between 5 mm and 10 degrees", "claim turn >", {"#2"}),
        ("turned by 3", "claim turn >", {"#1"}),
    ],
)
def test_a_number_stands_where_its_unit_fits(text, prefix, words):
    numbers = quantities(text)
    allowed = next_words(prefix.split(), len(numbers))
    assert fitting(prefix.split(), allowed, numbers) == words


def test_without_a_size_no_scale_can_be_told():
    allowed = next_words(["fact"], 1)
    left_out = allowed - fitting(["fact"], allowed, quantities("it turned 5 degrees"))
    assert left_out == {"scale", "view"}


def test_what_is_meant_is_never_left_out():
    pairs = [*islice(grammar().pairs(5, "validation"), 400), *corpus("validation")]
    for pair in pairs:
        words, numbers = pair.query.split(), quantities(pair.text)
        slots = {f"#{place}" for place in range(1, len(numbers) + 1)}
        for place, word in enumerate(words):
            allowed = slots if word in slots else {word}
            assert word in fitting(words[:place], allowed, numbers), pair


@pytest.mark.parametrize(
    ("text", "mm_each"),
    [
        ("20 px equal one millimetre", 0.05),
        ("1 mm = 16 px", 0.0625),
        ("320 pixels span 16 mm", 0.05),
        ("0.06 mm per pixel", 0.06),
    ],
)
def test_pixels_that_equal_a_length_are_one_scale(text, mm_each):
    (found,) = quantities(f"My calibration says {text}.")
    assert mm_per_px(found) == pytest.approx(mm_each)
    assert [one.unit for one in quantities("one pixel is 0.06 mm")] == ["px", "mm"]
