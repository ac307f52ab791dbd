"""The verbs for motion stand in one place, and every room reads them there."""

import re
from pathlib import Path

import pytest

import geotlm_lm.conversation as room
from geotlm_lm.conversation.motion_verbs import GOES, SLIDES, TURNS, base_of, forms


@pytest.mark.parametrize(
    ("said", "base"),
    [("turned", "turn"), ("spun", "spin"), ("slid", "slide"), ("went", "go"), ("slips", "slip")],
)
def test_a_form_has_its_base(said, base):
    assert base_of(said) == base


def test_other_words_have_none():
    assert base_of("cap") is None


def test_forms_are_those_asked_for():
    assert re.fullmatch(forms(TURNS, "gerund"), "rotating")
    assert not re.fullmatch(forms(TURNS, "base"), "rotating")
    assert re.fullmatch(forms(SLIDES + GOES), "crept")


def test_no_other_room_lists_their_stems():
    stems = re.compile(r"\brotat\|")
    rooms = sorted(Path(room.__file__).parent.glob("*.py"))
    assert [path.stem for path in rooms if stems.search(path.read_text())] == ["motion_verbs"]
