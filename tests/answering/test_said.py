"""Answers agree where they say the same, or one the same and more."""

import pytest

from geotlm_lm.answering.said import Said
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.query.decision import Decision, Movement
from geotlm_lm.query.text import read

FRAME = FrameSpec()


def said(line, *ways, frame=FRAME, **told):
    movements = tuple(Movement(way, None, None, 0.9, barely=False) for way in ways)
    (part,) = read(line).parts
    return Said(f"{line} {ways}", frame, (Decision(part, frame, movements=movements, **told),))


TURN = said("way turn", Motion.CLOCKWISE)


@pytest.mark.parametrize(
    ("other", "agrees"),
    [
        (TURN, True),
        (said("way", Motion.CLOCKWISE, Motion.LEFT), True),
        (said("way", Motion.LEFT), False),
        (said("way turn", Motion.COUNTERCLOCKWISE), False),
        (said("mirror > way", Motion.CLOCKWISE), False),
        (said("way", Motion.CLOCKWISE, frame=FrameSpec(image_mirrored=True)), False),
        (said("claim cw", Motion.CLOCKWISE, verdict=True), False),
        (said("way", missing="pixel"), False),
    ],
)
def test_an_answer_on_one_component_agrees_with_one_that_holds_it(other, agrees):
    assert TURN.agrees_with(other) is agrees
    assert other.agrees_with(TURN) is agrees


def test_two_claims_that_are_so_do_not_agree():
    one = said("claim turn", Motion.CLOCKWISE, verdict=True)
    assert not one.agrees_with(said("claim cw", Motion.CLOCKWISE, verdict=True))


def test_comparisons_agree_on_what_both_clips_show():
    def both(line, verdict, *each):
        (part,) = read(line).parts
        decisions = tuple(one.decisions[0] for one in each)
        return Said(line, FRAME, (Decision(part, FRAME, verdict=verdict, each=decisions),))

    other = said("way turn", Motion.COUNTERCLOCKWISE)
    all_ = said("way", Motion.COUNTERCLOCKWISE, Motion.LEFT)
    turns = both("compare same turn", False, TURN, other)
    assert turns.agrees_with(both("compare same way", False, TURN, all_))
    assert not turns.agrees_with(both("compare same way", True, TURN, all_))
    assert not turns.agrees_with(both("compare opposite turn", False, TURN, other))
