"""One of two clips by its place, its number or its letter."""

import re
from pathlib import Path

import pytest

import geotlm_lm.conversation as room
from geotlm_lm.conversation.clip_names import clips_by_number, named_alone, place_named
from geotlm_lm.conversation.two_claims import asks_of_two, claimed_each, claimed_subject
from geotlm_lm.core.labels import Motion


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("does the first one turn?", 0),
        ("clip 2: which way?", 1),
        ("how far does the 2nd go?", 1),
        ("which way does recording one go?", 0),
    ],
)
def test_a_clip_is_named_alone(text, place):
    assert place_named(named_alone(text)) == place


@pytest.mark.parametrize("text", ["is the first turn over?", "does clip 1 turn like clip 2?"])
def test_no_clip_or_two_are_not_one_alone(text):
    assert named_alone(text) is None


def test_letters_are_told_as_places():
    assert clips_by_number("Does A turn like B?") == "Does the first one turn like the second one?"


def test_claims_know_the_short_ordinals_as_well():
    assert claimed_subject("Is the 2nd one faster?") == 1
    assert claimed_each("Is the 1st one still and the 2nd one turning left?") == (
        {Motion.STILL},
        {Motion.COUNTERCLOCKWISE},
    )
    assert asks_of_two("Does the 1st turn faster?")
    assert not asks_of_two("Is the first one faster than 3 mm/s?")
    assert asks_of_two("If clip 1st were mirrored, would they turn the same way?")


def test_no_other_room_says_how_a_clip_is_named():
    says = re.compile(r"one\|clip\|recording|first\|(?:1st|second\|1)|clip 1")
    rooms = sorted(Path(room.__file__).parent.glob("*.py"))
    assert [path.stem for path in rooms if says.search(path.read_text())] == ["clip_names"]
