"""What leans on what was asked before is spelled out, by exchanging expressions."""

import pytest
from hypothesis import given, settings

from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.lines import normal, read, write
from geotlm_lm.query.program import Program
from tests.query.programs import expressions


def spelled(now: str, before: str) -> str:
    return write(resumed(read(now), read(before)))


@pytest.mark.parametrize(("before", "now", "meant"), [
    ("way turn", "mirror again", "mirror way turn"),
    ("mirror way turn", "mirror again", "way turn"),
    ("mirror way turn", "plain again", "way turn"),
    ("way turn", "as-sensor again", "as-sensor way turn"),
    ("amount turn", "unit rad again", "unit rad amount turn"),
    ("way turn", "unit deg again", "amount turn"),
    ("unit turn amount turn", "instead slide again", "unit turn amount slide"),
    ("way all", "unit mm again", "unit mm amount slide"),
    ("turn", "> again 20.0:deg", "> amount turn 20.0:deg"),
    ("delay begin contact begin first turn-events", "unit frame again",
     "unit frame delay begin contact begin first turn-events"),
    ("each-clip amount turn", "which-more again", "which-more amount turn"),
    ("each-clip amount turn", "unit rad again", "each-clip unit rad amount turn"),
    ("each-clip begin contact", "which-less again", "which-less clock begin contact"),
    ("each-clip amount turn", "of-second again", "of-second amount turn"),
    ("each-clip amount turn", "each-clip within first turn-events again",
     "each-clip within first turn-events amount turn"),
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
    ("> amount slide 10.0:px", "> again 30.0:px", "> amount slide 30.0:px"),
    ("> amount slide 10.0:px", "with 30.0:px again", "> amount slide 30.0:px"),
    ("in-range amount turn 5.0:deg 9.0:deg", "with 7.0:deg again",
     "in-range amount turn 7.0:deg 9.0:deg"),
    ("way turn", "instead slide again", "way slide"),
    ("way all", "instead up again", "up"),
    ("within final 0.2:s contact amount turn", "instead slide again",
     "within final 0.2:s contact amount slide"),
    ("count cw-events", "instead ccw again", "count ccw-events"),
    ("amount turn", "instead speed again", "speed turn"),
    ("way turn", "instead speed again", "speed turn"),
    ("mirror cw", "instead amount again", "mirror amount cw"),
    ("> amount turn 30.0:deg", "margin again", "margin > amount turn 30.0:deg"),
    ("begin first turn-events", "count those", "count turn-events"),
    ("slide", "begins those", "begins slide-events"),
    ("peak turn", "at then slide", "at peak-time turn slide"),
    ("at t 1.0:s turn", "within until then amount turn", "within until t 1.0:s amount turn"),
    ("touch", "count those", "count touch-events"),
    ("story", "instead turn again", "way turn"),
    ("happens slide-events", "instead amount again", "amount slide"),
    ("high amount turn", "low again", "low amount turn"),
    ("> amount turn 30.0:deg", "unit deg margin again",
     "unit deg margin > amount turn 30.0:deg"),
    ("right", "extent", "amount slide"),
    ("way turn", "speed move", "speed turn"),
    ("way all", "extent", "extent"),
    ("> amount turn 10.0:deg", "> amount move 20.0:", "> amount turn 20.0:deg"),
    ("amount turn", "< amount move 20.0:", "< amount turn 20.0:"),
    ("> amount turn 10.0:deg", "> amount move 20.0:px", "> amount move 20.0:px"),
    ("way turn", "at end again turn", "at end largest turn-events turn"),
    ("way turn", "ever again", "ever turn"),
    ("touch", "length it", "length contact"),
    ("tighten", "begin it", "begin largest turn-events"),
    ("within first move-events way all", "within since end it again",
     "within since end first move-events way all"),
    ("record @1 way turn , @2 amount turn , @3 amount slide end ; as json", "unit rad again",
     "record @1 way turn , @2 unit rad amount turn , @3 amount slide end ; as json"),
    ("record @1 way turn end ; as dict", "record again , @2 touch end",
     "record @1 way turn , @2 touch end ; as dict"),
    ("record @1 amount turn end ; as yaml", "record unit rad again , @2 touch end",
     "record @1 unit rad amount turn , @2 touch end ; as yaml"),
    ("record @1 count turn-events , @2 speed turn end ; as json", "unit rad again",
     "record @1 count turn-events , @2 speed turn end ; as json"),
    ("record @1 way turn , @2 speed turn end ; as json", "per per-frame again",
     "record @1 way turn , @2 per per-frame speed turn end ; as json"),
    ("behind record @1 way turn , @2 amount turn end ; as json", "unit rad again",
     "behind record @1 way turn , @2 unit rad amount turn end ; as json"),
    ("record @1 way turn end ; as json", "mirror again",
     "mirror record @1 way turn end ; as json"),
    ("record @1 way turn , @2 amount turn end ; as json", "percent-of unit turn again 1",
     "percent-of unit turn amount turn 1"),
    ("turn ; as json", "slide", "slide"),
    ("behind way turn", "extent", "behind amount turn"),
    ("mirror way slide", "mirror speed move", "mirror speed slide"),
    ("each slide-events amount slide", "unit mm again", "each slide-events unit mm amount slide"),
    ("each turn-events record begin here , amount turn end", "round 0 again",
     "each turn-events record begin here , round 0 amount turn end"),
    ("unit percent amount turn", "unit rad again", "unit rad amount turn"),
    ("round 1 unit mm amount turn", "unit deg again", "round 1 amount turn"),
    ("within part 1 2 contact unit mm amount slide", "unit px again",
     "unit px within part 1 2 contact amount slide"),
    ("choose @1 > amount turn 15.0:deg | @2 other ; as bare", "with 30.0:deg again",
     "choose @1 > amount turn 30.0:deg | @2 other ; as bare"),
    ("record @1 slide , @2 > amount turn 5.0:deg end", "with 5.0:deg again",
     "record @1 slide , @2 > amount turn 5.0:deg end"),
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
    asked = (
        *("unit deg again", "> again 20.0:deg", "length it", "within recording again", "it"),
        *("instead slide again", "instead speed again", "with 5.0:deg again", "count those"),
        "at then turn",
    )
    for now in asked:
        found = resumed(read(now), before)
        assert write(read(write(found))) == write(found)


def test_own_words_for_the_rest_can_be_leaned_on():
    before = "choose @1 > amount turn 20.0:deg | @2 other ; as bare"
    assert spelled("it", before) == "largest turn-events ; as bare"
