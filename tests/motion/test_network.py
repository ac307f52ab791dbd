"""The network before and after it has learned: what it tells agrees with itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.core.twist import COMPONENTS, WAYS, Component
from geotlm_lm.motion.measured import CANDIDATES, Measured
from geotlm_lm.motion.network import (
    GREEN_CHAINED,
    GREEN_DIRECT,
    START_WEIGHT,
    MotionNetwork,
    belief_of_one,
)

HINTS = 7


def found(count=6, seed=0):
    draw = torch.Generator().manual_seed(seed)
    paths = torch.randn(count, CANDIDATES, 3, generator=draw) * 10
    radius = torch.rand(count, generator=draw) * 30 + 4
    return Measured(paths, radius, torch.randn(count, HINTS, generator=draw))


@pytest.fixture(scope="module")
def trained():
    """A network of random weights, as one that has learned something else than to measure."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(1)
        return MotionNetwork(HINTS).eval().requires_grad_(False)


def test_before_training_it_tells_the_measured_fusion():
    network = MotionNetwork(HINTS).eval().requires_grad_(False)
    network.start_at_measured()
    seen = found()
    told = network(seen)
    # e^2 times the weight of each other candidate.
    weights = torch.ones(CANDIDATES)
    weights[[GREEN_CHAINED, GREEN_DIRECT]] = math.exp(START_WEIGHT)
    fused = (seen.paths * (weights / weights.sum())[:, None]).sum(dim=1)
    torch.testing.assert_close(told.path, fused)
    agreed = replace(seen, paths=seen.paths[:, :1].expand(-1, CANDIDATES, -1))
    torch.testing.assert_close(network(agreed).path, agreed.paths[:, 0])
    assert not told.inward_mm.any()
    assert torch.equal(told.counts.sigmoid(), torch.full((6, 3), 0.5))


def test_hints_beyond_all_measure_leave_what_is_told_finite(trained):
    seen = found()
    for strange in (1e30, -1e30):
        told = trained(replace(seen, hints=torch.full_like(seen.hints, strange)))
        assert bool(told.vector().isfinite().all())
        assert bool((told.deviation > 0).all())


def heading(trained, *ways, deviation=1.0):
    told = trained(found(len(ways)))
    path = torch.tensor([(0.0, *way) for way in ways])
    return replace(told, path=path, deviation=torch.full((len(ways), 4), deviation))


def test_quarters_sum_to_one_and_turn_with_the_way(trained):
    angles = torch.linspace(-3.0, 3.0, 13)
    ways = torch.stack([angles.cos(), angles.sin()], dim=1) * 5
    shares = heading(trained, *ways.tolist()).quarters()
    torch.testing.assert_close(shares.sum(dim=1), torch.ones(13))
    # A quarter clockwise as drawn: right comes to be down, down left.
    turned = torch.stack([-ways[:, 1], ways[:, 0]], dim=1)
    torch.testing.assert_close(heading(trained, *turned.tolist()).quarters(), shares.roll(1, 1))
    nearest = torch.remainder((angles / (math.pi / 2)).round(), 4)
    assert torch.equal(shares.argmax(dim=1).float(), nearest)


def test_a_slide_is_surer_of_its_quarter_the_farther_it_goes(trained):
    shares = heading(trained, (0.5, 0.0), (2.0, 0.0), (20.0, 0.0)).quarters()[:, 0].tolist()
    assert shares == sorted(shares)
    assert (shares[0] < 0.8, shares[2] > 0.99) == (True, True)
    diagonal = heading(trained, (9.0, 9.0)).quarters()[0]
    assert diagonal[:2].tolist() == pytest.approx([0.5, 0.5], abs=0.01)


def test_doubt_widens_what_is_believed_and_draws_probabilities_towards_a_half(trained):
    told = trained(found())
    for place in range(6):
        sure, doubted = (belief_of_one(told, place, doubt=doubt) for doubt in (1.0, 3.0))
        assert doubted.mean == sure.mean
        np.testing.assert_allclose(doubted.covariance, 9 * sure.covariance, rtol=1e-5)
        for component in COMPONENTS:
            shares = sure.moves(component), doubted.moves(component)
            assert abs(shares[1] - 0.5) <= abs(shares[0] - 0.5)


def test_a_belief_says_what_the_network_told(trained):
    told = trained(found())
    for place in range(6):
        belief, radius = belief_of_one(told, place), float(told.radius_px[place])
        counts = told.counts[place].sigmoid().tolist()
        assert [belief.moves(one) for one in COMPONENTS] == pytest.approx(counts)
        assert all(0 <= share <= 1 for share in belief.ways.values())
        turn, right, down = told.path[place].tolist()
        assert math.radians(belief.mean.turn_deg) * radius == pytest.approx(turn, rel=1e-5)
        assert (belief.mean.right_px, belief.mean.down_px) == pytest.approx((right, down))
        assert belief.path(Component.TURN) == pytest.approx(abs(turn), rel=1e-5)
        spread = belief.deviation(Component.TURN) * radius * math.pi / 180
        assert spread == pytest.approx(float(told.deviation[place, 0]), rel=1e-5)
        # The likeliest sense of a turn is that of its mean; the press has a logit of its own.
        assert belief.mean.along(belief.way(Component.TURN)) > 0
        inward = float(told.press_in[place].sigmoid())
        assert belief.share(WAYS[Component.PRESS][0], Component.PRESS) == pytest.approx(inward)
        assert belief.readable == dict(
            zip(COMPONENTS, (told.readable[place] >= 0).tolist(), strict=True)
        )
