"""Laws of what belongs together: one claim, one content, every order."""

import numpy as np
import pytest

from geotlm_lm.conversation.motion_claims import offered_options
from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.question_groups import in_every_order, reworded, said_and_denied

SEEDS = range(6)


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_claim_and_its_denial_name_one_motion_and_have_opposite_verdicts(seed, wordings):
    rng = np.random.default_rng(seed)
    said, denied = said_and_denied(MotionLabel(Motion.LEFT), rng, wordings)
    assert (said.type_id, denied.type_id) == ("T2", "T4")
    assert claimed_motion(said.question) == claimed_motion(denied.question)
    assert said.slots.verdict != denied.slots.verdict
    assert said.slots.direction == denied.slots.direction == Motion.LEFT


@pytest.mark.parametrize("type_id", ["T1", "T2", "T4", "T5", "T18"])
def test_rewordings_differ_in_their_words_and_agree_in_their_answer(type_id):
    rng = np.random.default_rng(3)
    asked = reworded(MotionLabel(Motion.CLOCKWISE), type_id, 4, rng)
    assert len({one.wording_id for one in asked}) == 4
    assert len({one.answer for one in asked}) == 1


@pytest.mark.parametrize("seed", SEEDS)
def test_every_option_of_a_choice_is_once_in_front(seed):
    asked = in_every_order(MotionLabel(Motion.PRESS), np.random.default_rng(seed))
    orders = [list(offered_options(one.question).values()) for one in asked]
    assert len(orders) == len(orders[0])
    assert len({order[0] for order in orders}) == len(orders)
    assert {frozenset(order) for order in orders} == {frozenset(orders[0])}


def test_the_right_letter_moves_with_the_order_and_the_right_motion_stays():
    asked = in_every_order(MotionLabel(Motion.RIGHT), np.random.default_rng(1))
    assert {one.slots.direction for one in asked} == {Motion.RIGHT}
    assert len({one.slots.letter for one in asked}) == len(asked)
