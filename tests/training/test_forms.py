"""Questions for an output of a given form are read as meant, can be answered, and vary."""

from itertools import islice
from random import Random

import pytest

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query.answers import answers
from geotlm_lm.query.copied import copied
from geotlm_lm.query.lines import normal, read, write
from geotlm_lm.query.program import MOST_COPIED, MOST_SLOTS, filled
from geotlm_lm.query.quantities import find
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.written import worded
from geotlm_lm.training.forms import Draft, _forms, formed
from geotlm_lm.training.grammar import SPLITS, numbered, split_of
from tests.query.programs import there_and_back

FRAME = FrameSpec(mm_per_px=0.05, thread="right", contact_side="head")


@pytest.fixture(scope="module")
def clip():
    return there_and_back()


def test_there_are_many_parts():
    forms = _forms()
    assert len({each.program for each in forms.meanings}) >= 80
    assert all(4 <= len(each.keys) <= 12 for each in forms.meanings)
    assert len(forms.layouts) >= 60


@pytest.mark.parametrize("line", sorted({each.program for each in _forms().meanings}))
def test_every_meaning_can_be_answered(line, clip):
    (value,) = answers(read(line), (clip,), FRAME)
    assert getattr(value, "reason", "") in ("", "area", "none-such", "alone", "touched")


@pytest.mark.parametrize("split", SPLITS)
def test_every_pair_is_read_and_answered_in_its_form(split, clip):
    for pair in islice(formed(Random(3), split), 150):
        numbers = [each.quantity for each in find(pair.text)[:MOST_SLOTS]]
        words = [each.text for each in copied(pair.text)[:MOST_COPIED]]
        program = read(pair.query, len(numbers), len(words))
        assert write(normal(program)) == pair.query
        program = filled(program, numbers, words)
        values = answers(program, (clip,), FRAME)
        assert worded(values, program.form, Teller(clip.recording, FRAME), 0.9).text
        assert all(split_of(family) == split for family in pair.families)


def test_no_layout_stands_in_two_splits():
    of_split = {}
    for layout in _forms().layouts:
        about = layout.form, layout.around, layout.field, layout.between, layout.style
        assert of_split.setdefault(about, layout.id) == layout.id


def test_equal_numbers_are_copied_each_from_where_it_stands():
    draft = Draft()
    (first, one), (second, other) = draft.mark_anew("12"), draft.mark_anew("12")
    pair = numbered(f"{first} degrees, {second} px", f"> amount slide {other}", ())
    assert one != other
    assert pair.query == "> amount slide #2"


def test_no_pair_comes_twice_but_by_chance():
    pairs = list(islice(formed(Random(5), "train"), 2000))
    assert len({(pair.text, pair.query) for pair in pairs}) > 1980


def test_the_same_draws_give_the_same_pairs():
    assert list(islice(formed(Random(7)), 50)) == list(islice(formed(Random(7)), 50))
