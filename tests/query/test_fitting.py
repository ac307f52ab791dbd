"""Numbers stand where their unit lets them: what is meant is never left out."""

from itertools import islice

import pytest

from geotlm_lm.query.copied import copied
from geotlm_lm.query.evaluate import mm_per_px
from geotlm_lm.query.lines import END, fitting
from geotlm_lm.query.program import MOST_COPIED, MOST_SLOTS
from geotlm_lm.query.quantities import quantities
from geotlm_lm.training.grammar import corpus, grammar


@pytest.mark.parametrize(
    ("text", "prefix", "slots"),
    [
        ("1 pixel is 0.04 mm wide", "fact scale", {"#2"}),
        ("below 0.2 mm? It turned 4 degrees", "< amount turn", {"#2"}),
        ("after 3 s, more than 2 px?", "within between t", {"#1"}),
        ("between 5 mm and 10 degrees", "> amount turn", {"#2"}),
        ("5 degrees in the last 2 s", "within final", {"#2"}),
        ("3 times by 20 degrees", "= count turn-events", {"#1"}),
        ("turned by 3", "> amount turn", {"#1"}),
        ("2 s, 5 mm and 10 degrees", "> unit mm amount slide", {"#2"}),
    ],
)
def test_a_number_stands_where_its_unit_fits(text, prefix, slots):
    found = fitting(prefix.split(), quantities(text))
    assert {word for word in found if word.startswith("#")} == slots


def test_without_a_size_no_scale_can_be_stated():
    size, turn = (fitting(["fact"], quantities(text)) for text in ("5 mm", "5 degrees"))
    assert size - turn == {"scale", "view"}


def test_what_is_meant_is_never_left_out():
    pairs = [*islice(grammar().pairs(5, "validation"), 250), *corpus("validation")]
    for pair in pairs:
        words, numbers = [*pair.query.split(), END], quantities(pair.text)[:MOST_SLOTS]
        texts = len(copied(pair.text)[:MOST_COPIED])
        for place, word in enumerate(words):
            assert word in fitting(words[:place], numbers, texts), pair


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


@pytest.mark.parametrize(
    ("text", "stated"),
    [
        ("between 200 and 500 ms", [(200, "ms"), (500, "ms")]),
        ("frames 30 to 45", [(30, "frame"), (45, "frame")]),
        ("from 5 px or 2 degrees", [(5, "px"), (2, "deg")]),
        ("the time in mm after 3 s in mm", [(3, "s")]),
        ("a sixty degree turn", [(60, "deg")]),
        ("one sixty degrees", [(160, "deg")]),
        ("two-thirds of a full turn", [(2 / 3, "turn")]),
        ("30 degrees in the second touch", [(30, "deg")]),
        ("30 degrees in the second", [(30, "deg/s")]),
    ],
)
def test_a_number_has_the_unit_that_is_meant(text, stated):
    assert [(each.value, each.unit) for each in quantities(text)] == stated
