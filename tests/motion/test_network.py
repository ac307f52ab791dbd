"""The mixture of what is measured, and the bounds within which a network may bend it."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.motion.measured import CANDIDATES, SHEAR_NOISE_PX, Measured
from geotlm_lm.motion.network import LOG_GAIN, Candidates, MotionNetwork, belief_of_one

HINTS = 40


def seen(count=6, seed=0, *, paths=None, white=0.01, growth=0.0):
    draw = torch.Generator().manual_seed(seed)
    if paths is None:
        paths = torch.randn(count, CANDIDATES, 3, generator=draw) * 10
    count = len(paths)
    deviations = torch.full((count, CANDIDATES, 3), white)
    deviations[:, -1] = SHEAR_NOISE_PX
    return Measured(
        paths,
        deviations,
        torch.ones(count, CANDIDATES, dtype=torch.bool),
        torch.full((count,), growth),
        torch.rand(count, generator=draw) * 30 + 4,
        torch.randn(count, HINTS, generator=draw),
    )


def alike(*motions, **how):
    """Clips of each of whose motions all candidates tell the same."""
    return seen(paths=torch.tensor(motions)[:, None].expand(-1, CANDIDATES, -1), **how)


@pytest.fixture(scope="module")
def untrained():
    return MotionNetwork(HINTS).eval().requires_grad_(False)


@pytest.fixture(scope="module")
def trained():
    """A network of large random weights, as one that has learned anything at all."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(1)
        network = MotionNetwork(HINTS).eval().requires_grad_(False)
        network.see(torch.randn(400, HINTS))
        network.out.weight.normal_(0, 3)
        network.out.bias.normal_(0, 3)
    return network


def test_before_training_it_believes_what_the_candidates_agree_on(untrained):
    motions = ((5.0, 3.0, -2.0), (0.0, -40.0, 1.0))
    torch.testing.assert_close(untrained(alike(*motions)).path, torch.tensor(motions))


def test_a_candidate_that_disagrees_is_left_out_and_not_averaged(untrained):
    paths = torch.tensor([[3.0, -3.0, 0.5]]).repeat(CANDIDATES, 1)
    paths[2:4, 1:] = torch.tensor([0.0, -67.0])
    believed = untrained(seen(paths=paths[None]))
    assert believed.path[0].tolist() == pytest.approx([3.0, -3.0, 0.5], abs=0.1)
    assert float(believed.slide_weights[0, 2:4].sum()) < 0.01


def test_what_is_not_measured_has_no_weight(untrained):
    own = seen()
    own.is_measured[:, 2:4] = False
    believed = untrained(own)
    assert not believed.turn_weights[:, 2:4].any()
    torch.testing.assert_close(believed.turn_weights.sum(dim=1), torch.ones(6))


def test_nothing_learned_turns_an_agreed_motion_round_nor_stretches_it_beyond_bounds(trained):
    turns = torch.linspace(-20, 20, 41)
    motions = [(turn, turn / 2, -turn) for turn in turns.tolist()]
    path = trained(alike(*motions)).path
    assert bool((path[:, 0].sign() == turns.sign()).all())
    gains = (path[:, 0] / turns)[turns != 0]
    low, high = (math.exp(bound) for bound in LOG_GAIN)
    assert low - 1e-4 <= float(gains.min()) <= float(gains.max()) <= high + 1e-4


def test_far_from_what_was_seen_nothing_learned_is_used(trained, untrained):
    own = seen()
    far = replace(own, hints=torch.full_like(own.hints, 1e30))
    assert bool((trained(own).path != untrained(own).path).any(dim=1).all())
    torch.testing.assert_close(trained(far).path, untrained(far).path)
    assert np.isfinite(belief_of_one(trained(far)).vector()).all()


def test_a_motion_is_told_from_noise_by_its_significance_not_its_size(untrained):
    motions = ((0.2, 0.0, 0.0), (0.0, 0.0, 0.2), (0.01, 0.0, 0.01))
    sharp, noisy = (untrained(alike(*motions, white=white)) for white in (0.005, 0.1))
    assert (sharp.moves[:, :2] > 0).tolist() == [[True, False], [False, True], [False, False]]
    assert not (noisy.moves[:, :2] > 0).any()


def test_twice_the_noise_raises_the_limit_to_twice(untrained):
    motions = ((0.0, 0.0, 0.0),)
    limits = [untrained(alike(*motions, white=w)).limits[0, :2] for w in (0.003, 0.006)]
    torch.testing.assert_close(limits[1], 2 * limits[0], rtol=0.2, atol=0)


def test_what_grows_has_to_move_farther_to_be_seen(untrained):
    still, growing = (untrained(alike((0.5, 0.0, 0.0), growth=g)) for g in (0.0, 1.0))
    assert float(growing.limits[0, 0]) > 3 * float(still.limits[0, 0])
    assert (float(still.moves[0, 0]) > 0, float(growing.moves[0, 0]) > 0) == (True, False)


def test_beside_a_turn_a_slide_is_doubted_by_where_the_middle_may_lie(untrained):
    alone, beside = (untrained(alike((turn, 0.0, 3.0))) for turn in (0.0, 10.0))
    assert float(beside.limits[0, 1]) > 5 * float(alone.limits[0, 1])
    # The farther out the contact reaches, the less a turn by that path is.
    wide = replace(alike((10.0, 0.0, 3.0)), radius_px=torch.tensor([200.0]))
    assert float(untrained(wide).limits[0, 1]) < float(beside.limits[0, 1])


def test_candidates_that_hardly_agree_raise_the_limit_and_no_span_told_reaches_zero(untrained):
    paths = torch.tensor([[0.0, 5.0, 0.0]]).repeat(2, CANDIDATES, 1)
    paths[1, 1:, 1] = 3.9
    believed = untrained(seen(paths=paths))
    assert float(believed.limits[1, 1]) > 3 * float(believed.limits[0, 1])
    wide = replace(believed, deviation=torch.full((2, 4), 9.0))
    assert float(wide.moves[0, 1]) > 0
    assert float(5 - 1.645 * wide.stated[0, 1]) > 0
    assert float(wide.stated[0, 0]) == 9  # what is not told may reach zero


def test_a_mixture_turns_and_mirrors_with_its_candidates():
    own = seen(50)
    noise, gate = torch.full((50, CANDIDATES, 2), 0.1), torch.zeros(50, CANDIDATES)
    quarter = torch.tensor([[0.0, -1.0], [1.0, 0.0]])
    slides = own.paths[..., 1:]
    plain, turned, mirrored = (
        Candidates(ways, noise).mixed(gate).value for ways in (slides, slides @ quarter.T, -slides)
    )
    torch.testing.assert_close(turned, plain @ quarter.T)
    torch.testing.assert_close(mirrored, -plain)


def heading(untrained, *ways, deviation=1.0):
    believed = untrained(seen(len(ways)))
    path = torch.tensor([(0.0, *way) for way in ways])
    return replace(believed, path=path, deviation=torch.full((len(ways), 4), deviation))


def test_quarters_sum_to_one_and_turn_with_the_way(untrained):
    angles = torch.linspace(-3.0, 3.0, 13)
    ways = torch.stack([angles.cos(), angles.sin()], dim=1) * 5
    shares = heading(untrained, *ways.tolist()).quarters()
    torch.testing.assert_close(shares.sum(dim=1), torch.ones(13))
    # A quarter clockwise as drawn: right comes to be down, down left.
    turned = torch.stack([-ways[:, 1], ways[:, 0]], dim=1)
    torch.testing.assert_close(heading(untrained, *turned.tolist()).quarters(), shares.roll(1, 1))
    nearest = torch.remainder((angles / (math.pi / 2)).round(), 4)
    assert torch.equal(shares.argmax(dim=1).float(), nearest)


def test_doubt_widens_what_is_believed_and_draws_ways_towards_a_half(trained):
    believed = trained(seen())
    for place in range(6):
        sure, doubted = (belief_of_one(believed, place, doubt=doubt) for doubt in (1.0, 3.0))
        assert doubted.mean == sure.mean
        # What is told only when nothing is doubted is kept from zero then.
        assert (np.diag(doubted.covariance) >= np.diag(sure.covariance) * (1 - 1e-6)).all()
        for component in COMPONENTS:
            assert doubted.limits[component] == pytest.approx(3 * sure.limits[component])
            shares = [each.share(each.way(component), component) for each in (sure, doubted)]
            assert shares[1] <= shares[0] + 1e-6


def test_a_belief_says_what_the_network_believes(trained):
    believed = trained(seen())
    for place in range(6):
        belief, radius = belief_of_one(believed, place), float(believed.radius_px[place])
        moves = believed.moves[place].sigmoid().tolist()
        assert [belief.moves(part) for part in COMPONENTS] == pytest.approx(moves)
        turn, right, down = believed.path[place].tolist()
        assert math.radians(belief.mean.turn_deg) * radius == pytest.approx(turn, rel=1e-5)
        assert (belief.mean.right_px, belief.mean.down_px) == pytest.approx((right, down))
        spread = belief.deviation(Component.TURN) * radius * math.pi / 180
        assert spread == pytest.approx(float(believed.stated[place, 0]), rel=1e-5)
        limits = believed.limits[place].tolist()
        assert [belief.limits[part] for part in COMPONENTS] == pytest.approx(limits)
        readable = (believed.readable[place] >= 0).tolist()
        assert belief.readable == dict(zip(COMPONENTS, readable, strict=True))
