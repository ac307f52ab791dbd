"""Laws of a Belief: what mirrors and reversal do, and that its parts agree."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from geotlm_lm.core.edit import BACKWARDS, MIRRORED
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, WAYS, Component, Twist
from geotlm_lm.motion.belief import BELIEF_NUMBERS, Belief, fused, kept_from_zero

SHARES = st.floats(0, 1)


@st.composite
def beliefs(draw):
    twist = Twist(*(draw(st.floats(-30, 30)) for _ in range(4)))
    factor = np.array([[draw(st.floats(-2, 2)) for _ in range(4)] for _ in range(4)])
    ways = {}
    for component in COMPONENTS:
        weights = [draw(st.floats(0.01, 1)) for _ in WAYS[component]]
        counts = draw(SHARES) / sum(weights)
        ways |= {w: share * counts for w, share in zip(WAYS[component], weights, strict=True)}
    readable = {component: draw(st.booleans()) for component in COMPONENTS}
    return Belief(twist, factor @ factor.T, ways, draw(SHARES), draw(st.floats(4, 60)), readable)


SEEN = (MIRRORED, BACKWARDS)


@given(beliefs(), st.sampled_from(SEEN), st.sampled_from(COMPONENTS))
def test_neither_changes_how_far_a_component_goes_nor_how_surely(belief, way, component):
    other = belief.seen(way)
    for told in (Belief.amount, Belief.deviation, Belief.path):
        assert told(other, component) == pytest.approx(told(belief, component), abs=1e-9)
    assert other.moves(component) == pytest.approx(belief.moves(component))
    assert other.by_size() == belief.by_size()


@given(beliefs(), st.sampled_from(COMPONENTS))
def test_shares_of_the_ways_sum_to_one_and_the_likeliest_is_told(belief, component):
    shares = [belief.share(way, component) for way in WAYS[component]]
    assert sum(shares) == pytest.approx(1.0)
    assert belief.share(belief.way(component), component) == max(shares)


@given(beliefs())
def test_fused_with_its_own_exact_reverse_it_is_what_it_was(belief):
    found = fused(belief, belief.seen(BACKWARDS))
    assert astuple(found.mean) == pytest.approx(astuple(belief.mean))
    np.testing.assert_allclose(found.covariance, belief.covariance, atol=1e-9)
    assert found.ways == pytest.approx(belief.ways)


@given(beliefs(), st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9))
def test_what_both_directions_of_play_are_inclined_to_cancels(belief, turn, right, down):
    def biased(one):
        mean = Twist(one.mean.turn_deg + turn, one.mean.right_px + right, one.mean.down_px + down)
        return replace(one, mean=replace(mean, inward_mm=one.mean.inward_mm))

    found = fused(biased(belief), biased(belief.seen(BACKWARDS)))
    assert astuple(found.mean) == pytest.approx(astuple(belief.mean))
    for component in (Component.TURN, Component.SLIDE):
        assert found.deviation(component) >= 0
    apart = np.diag(found.covariance - belief.covariance)
    assert apart == pytest.approx([2 * turn**2, 2 * right**2, 2 * down**2, 0.0], abs=1e-6)


@given(beliefs(), beliefs())
def test_fused_the_other_way_round_it_is_reversed(one, other):
    for ways in WAYS.values():  # of two ways that are as likely none is the one it goes
        assume(all(len({belief.ways[way] for way in ways}) == len(ways) for belief in (one, other)))
    other = replace(other, mean=replace(other.mean, inward_mm=-one.mean.inward_mm))
    there, back = fused(one, other), fused(other, one)
    assert astuple(there.mean) == pytest.approx(astuple(BACKWARDS.of_twist(back.mean)))
    for component in (Component.TURN, Component.SLIDE):
        assert there.moves(component) == pytest.approx(back.moves(component))


def test_a_way_that_does_not_turn_round_with_the_clip_hardly_counts():
    there = believed(Twist(5.0), clockwise=0.6, counterclockwise=0.35, press=0.9)
    same_way = believed(Twist(4.0), clockwise=0.55, counterclockwise=0.4, release=0.9)
    assert fused(there, same_way).moves(Component.TURN) < 0.5
    assert fused(there, there.seen(BACKWARDS)).moves(Component.TURN) == pytest.approx(0.95)
    assert fused(there, same_way).way(Component.PRESS) is Motion.PRESS
    slanting = believed(Twist(0.0, 4.0, 3.9), right=0.5, down=0.45)
    lifting = believed(Twist(0.0, -3.9, -4.0), left=0.45, up=0.5)
    assert fused(slanting, lifting).moves(Component.SLIDE) > 0.9


def test_a_turn_that_both_directions_of_play_show_is_told_however_far_apart_they_are():
    there = believed(Twist(17.0), clockwise=0.97)
    less_far = believed(Twist(-3.0), counterclockwise=0.95)
    found = fused(there, less_far)
    assert found.moves(Component.TURN) > 0.9
    assert found.way(Component.TURN) is Motion.CLOCKWISE
    assert found.deviation(Component.TURN) > there.deviation(Component.TURN)


def believed(twist, covariance=None, **counts):
    ways = {way: 0.0 for ways in WAYS.values() for way in ways}
    ways |= {Motion(way): share for way, share in counts.items()}
    covariance = np.eye(4) if covariance is None else covariance
    return Belief(twist, covariance, ways, 1.0, 20.0, dict.fromkeys(COMPONENTS, True))


def test_a_slides_spread_is_that_along_its_way():
    covariance = np.diag([1.0, 4.0, 0.25, 1.0])
    along = [(3.0, 0.0, 2.0), (0.0, -2.0, 0.5), (0.0, 0.0, 2.0), (1.0, 1.0, math.sqrt(2.125))]
    for right, down, spread in along:
        belief = believed(Twist(0.0, right, down), covariance)
        assert belief.deviation(Component.SLIDE) == pytest.approx(spread)


def test_the_component_that_moves_the_imprint_farther_comes_first():
    turn_first = believed(Twist(20.0, 3.0), clockwise=0.9, right=0.9, press=0.4)
    assert turn_first.by_size() == [Component.TURN, Component.SLIDE]
    press_first = believed(Twist(2.0, 0.0, 3.0, 0.5), clockwise=0.9, down=0.9, press=0.9)
    assert press_first.by_size() == [Component.PRESS, Component.SLIDE, Component.TURN]


def test_a_span_of_what_is_told_is_kept_from_zero_and_no_other():
    belief = believed(Twist(5.0, 0.0, 3.0), np.diag([25.0, 4.0, 0.01, 1.0]), clockwise=0.9, up=0.3)
    kept = kept_from_zero(belief)
    assert 1.645 * kept.deviation(Component.TURN) == pytest.approx(0.95 * 5)
    assert kept.deviation(Component.SLIDE) == belief.deviation(Component.SLIDE)


@given(beliefs())
def test_its_vector_is_finite_and_turns_round_with_the_clip(belief):
    forwards, backwards = belief.vector(), belief.seen(BACKWARDS).vector()
    assert forwards.shape == backwards.shape == (BELIEF_NUMBERS,)
    assert np.isfinite(forwards).all()
    signed, lengths = slice(0, 5), slice(5, 15)
    np.testing.assert_allclose(backwards[signed], -forwards[signed], atol=1e-9)
    np.testing.assert_allclose(backwards[lengths], forwards[lengths], atol=1e-6)


@given(beliefs())
def test_its_vector_tells_what_is_decided(belief):
    moves, order = belief.vector()[23:26], belief.vector()[26:29]
    assert (moves >= 0).tolist() == [belief.moves(c) >= 0.5 for c in COMPONENTS]
    ranks = dict.fromkeys(COMPONENTS, -3)
    ranks |= {component: -place for place, component in enumerate(belief.by_size())}
    turn, slide, press = (ranks[c] for c in COMPONENTS)
    assert order.tolist() == np.sign([turn - slide, turn - press, slide - press]).tolist()
