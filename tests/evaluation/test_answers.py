import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.evaluation.answers import (
    Verdict,
    false_claim_rate,
    grade,
    tally,
    within_tolerance,
)

CW, CCW, STILL = Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE, Motion.STILL


@pytest.mark.parametrize(
    ("answer", "verdict"),
    [(CW, Verdict.RIGHT), (CCW, Verdict.WRONG), (None, Verdict.UNPARSABLE)],
)
def test_an_answer_is_right_wrong_or_unparsable(answer, verdict):
    assert grade(CW, answer) == verdict


def test_the_tally_keeps_unparsable_answers_in_the_count():
    counts = tally([CW, CW, CCW], [CW, None, None])
    assert counts == {"right": 1, "wrong": 0, "unparsable": 2}


def test_a_direction_claimed_on_a_still_clip_is_a_false_claim():
    truths = [STILL, Motion.PRESS, Motion.NONE, STILL, CW]
    answers = [CW, Motion.RELEASE, None, Motion.LEFT, CCW]
    assert false_claim_rate(truths, answers) == 0.5


def test_no_false_claim_is_possible_when_every_clip_has_a_direction():
    assert false_claim_rate([CW], [CCW]) is None


def test_every_clip_needs_an_answer():
    with pytest.raises(ValueError, match="shorter"):
        tally([CW, CW], [CW])


@pytest.mark.parametrize(
    ("said", "true", "unit", "is_right"),
    [
        (6.0, 4.1, "deg", True),  # 2 degrees
        (6.2, 4.1, "deg", False),
        (24.0, 20.0, "deg", True),  # a fifth
        (24.1, 20.0, "deg", False),
        (0.5, 0.31, "mm", True),  # 0.2 mm
        (0.6, 0.31, "mm", False),
        (2.4, 3.0, "mm", True),
        (2.3, 3.0, "mm", False),
    ],
)
def test_an_amount_may_be_off_by_its_floor_or_a_fifth(said, true, unit, is_right):
    assert within_tolerance(said, true, unit) is is_right
