"""What leans on what was asked before is spelled out, by exchanging expressions."""

import pytest
from hypothesis import given, settings

from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.lines import read, write
from geotlm_lm.query.program import Program, normal
from tests.query.programs import expressions


def spelled(now: str, before: str) -> str:
    return write(resumed(read(now), read(before)))


@pytest.mark.parametrize(("before", "now", "meant"), [
    ("way turn", "mirror again", "mirror way turn"),
    ("mirror way turn", "mirror again", "way turn"),
    ("mirror way turn", "plain again", "way turn"),
    ("way turn", "as-sensor again", "as-sensor way turn"),
    ("amount turn", "unit rad again", "unit rad amount turn"),
    ("way turn", "unit deg again", "unit deg amount turn"),
    ("way all", "unit mm again", "unit mm amount slide"),
    ("turn", "> again 20.0:deg", "> amount turn 20.0:deg"),
    ("delay begin contact begin first turn-events", "unit frame again",
     "unit frame delay begin contact begin first turn-events"),
    ("begin first turn-events", "unit ms again", "unit ms clock begin first turn-events"),
    ("within part 1 2 contact amount turn", "within part 2 2 contact again",
     "within part 2 2 contact amount turn"),
    ("of-first way turn", "of-second again", "of-second way turn"),
    ("mirror within part 1 2 contact way all", "within recording again",
     "within recording mirror way all"),
    ("begin first turn-events", "length it", "length first turn-events"),
    ("cw", "within since end it story", "within since end largest cw-events story"),
    ("amount turn", "percent-of unit turn again 1", "percent-of unit turn amount turn 1"),
    ("way turn ; amount turn", "mirror again", "mirror way turn ; mirror amount turn"),
    ("turn ; as one-zero", "mirror again", "mirror turn ; as one-zero"),
    ("turn", "again ; as json", "turn ; as json"),
    ("turn", "fact mirrored ; again", "fact mirrored ; turn"),
    ("turn", "slide", "slide"),
])  # fmt: skip
def test_a_follow_up_is_spelled_out(before, now, meant):
    assert spelled(now, before) == meant


def test_without_anything_before_what_moves_is_asked_for():
    assert write(resumed(read("mirror again"), Program())) == "mirror way all"
    assert resumed(read("fact mirrored ; again"), Program()).answers == ()


@given(expressions())
@settings(max_examples=60, deadline=None)
def test_the_same_again_is_what_was_asked(expression):
    before = normal(Program((expression,)))
    assert resumed(read("again"), before).answers == before.answers
    assert resumed(read("mirror mirror again"), before).answers == before.answers


@given(expressions())
@settings(max_examples=60, deadline=None)
def test_whatever_was_asked_can_be_leaned_on(expression):
    before = Program((expression,))
    asked = ("unit deg again", "> again 20.0:deg", "length it", "within recording again", "it")
    for now in asked:
        found = resumed(read(now), before)
        assert write(read(write(found))) == write(found)


def test_own_words_for_the_rest_can_be_leaned_on():
    before = "choose @1 > amount turn 20.0:deg | @2 other ; as bare"
    assert spelled("it", before) == "largest turn-events ; as bare"
