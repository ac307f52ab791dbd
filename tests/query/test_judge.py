"""What was told is judged against the truth; expected are sentences written by hand."""

import math

import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.query.judge import judge_motion, true_movement
from geotlm_lm.query.program import Expression
from geotlm_lm.query.values import Moved, Unknown

WAY = Expression("way", ("all",))
TURNED, RIGHT = Twist(turn_deg=15), Twist(right_px=20)
BOTH = Twist(turn_deg=15, right_px=20)


def told(twist, rest=None):
    """Return the answer that tells just what moves in a motion."""
    return Moved(of=WAY, movements=tuple(true_movement(twist, part) for part in moving(twist)),
                 rest=rest)  # fmt: skip


def moving(twist):
    return [part for part in COMPONENTS if twist.path(part, 40.0) > 0]


def judged(value, twist, unseen=(), *, touches=True):
    parts = moving(twist)
    moves = {part: part in parts for part in COMPONENTS}
    is_visible = {part: moves[part] and part not in unseen for part in COMPONENTS}
    return judge_motion(value, twist, moves, is_visible, touches=touches)


def slide(degrees, far=20.0):
    """Return a slide by its direction, 0 right and 90 down."""
    angle = math.radians(degrees)
    return Twist(right_px=far * math.cos(angle), down_px=far * math.sin(angle))


@pytest.mark.parametrize(
    ("answer", "true", "text"),
    [
        (BOTH, BOTH, "correct: it turned clockwise 15 degrees and slid right 20 px"),
        (Twist(15, 0, -20), BOTH, "correct about the turn; it slid right 20 px, not up"),
        (TURNED, BOTH, "correct about the turn; it also slid right 20 px"),
        (BOTH, TURNED, "correct about the turn; it did not slide"),
        (Twist(-15, 20), BOTH, "correct about the slide; "
         "it turned clockwise 15 degrees, not counterclockwise"),
        (Twist(inward_mm=0.7), Twist(inward_mm=0.7, down_px=55),
         "correct about the press; it also slid down 55 px"),
        (Twist(14), Twist(60), "wrong: it turned clockwise 60 degrees, not 14 degrees"),
        (Twist(inward_mm=0.7), Twist(inward_mm=-0.7),
         "wrong: it lifted off 0.7 mm, not pressed in"),
        (Twist(), RIGHT, "wrong: it slid right 20 px"),
        (Twist(), Twist(), "correct: it did not move"),
    ],
)  # fmt: skip
def test_each_component_is_judged_by_its_way_and_its_amount(answer, true, text):
    result = judged(told(answer), true)
    assert (result.text, result.is_right) == (text, text.startswith("correct:"))


def test_an_amount_counts_within_its_tolerance_or_a_fifth():
    assert judged(told(Twist(17)), TURNED).is_right
    assert judged(told(Twist(71)), Twist(60)).is_right
    assert not judged(told(Twist(18.6)), TURNED).is_right


@pytest.mark.parametrize(
    ("answer", "true", "is_right"),
    [(0, 20, True), (20, 0, True), (20, -20, False), (20, 70, False), (40, 50, True),
     (20, 45, True), (0, 45, False), (45, 90, False), (0, 90, False), (0, 180, False)],
)  # fmt: skip
def test_a_slide_between_two_ways_is_right_by_both_of_them(answer, true, is_right):
    assert judged(told(slide(answer)), slide(true)).is_right is is_right


def test_what_does_not_show_need_not_be_told():
    hidden = judged(told(TURNED), BOTH, unseen=[Component.SLIDE])
    assert hidden.is_right
    assert hidden.text.endswith("15 degrees; it also slid right 20 px, which does not show")
    still = judged(told(Twist()), RIGHT, unseen=[Component.SLIDE])
    expected = "correct: it did not move visibly; it slid right 20 px, which does not show"
    assert (still.text, still.is_right) == (expected, True)


def test_contact_is_judged_as_well():
    nothing = told(Twist(), Motion.NONE)
    assert judged(nothing, Twist(), touches=False).is_right
    assert judged(told(Twist()), Twist(), touches=False).text == "wrong: nothing touched the gel"
    assert judged(nothing, RIGHT).text == "wrong: it touched the gel; it slid right 20 px"


def test_an_answer_that_is_withheld_is_not_right():
    withheld = Unknown(of=WAY, reason="contact")
    expected = "not told: it turned clockwise 15 degrees"
    result = judged(withheld, TURNED)
    assert (result.text, result.is_right) == (expected, False)
