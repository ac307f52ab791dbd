"""The network that believes: what its loss asks, and that it learns which measurement to trust."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.motion.measured import CANDIDATES, Measured
from geotlm_lm.motion.network import MotionNetwork
from geotlm_lm.training import motion
from geotlm_lm.training.motion import (
    Truths,
    motion_network_loss,
    motion_scores,
    set_significance,
    train_motion,
    widen_spans,
)

RADIUS = 20.0


def label(turn_deg=0.0, right=0.0, down=0.0, inward=0.0, **changes):
    made = MotionLabel(
        Motion.STILL,
        rotation_deg=turn_deg,
        depth_change_mm=inward,
        contact_fraction=(0.1,) * 4,
        travel_px=(right, down),
        radius_px=RADIUS,
        visible_grey=(9.0, 9.0, 9.0),
    )
    return replace(made, **changes)


def clips(count, seed=0):
    """Clips whose relief tells three quarters of the motion; what else is measured is noise."""
    rng = np.random.default_rng(seed)
    twists = rng.normal(size=(count, 4)) * (12.0, 5.0, 5.0, 0.3)
    twists[rng.random((count, 4)) < 0.3] = 0.0
    labels = [label(*twist) for twist in twists]
    true = np.stack([np.radians(twists[:, 0]) * RADIUS, twists[:, 1], twists[:, 2]], axis=1)
    paths = rng.normal(size=(count, CANDIDATES, 3)) * 4
    paths[:, 2:4] = true[:, None] * rng.normal(0.75, 0.05, (count, 1, 3))
    paths[:, 2:4] += rng.normal(size=(count, 2, 3)) * 0.02
    hints = [paths.reshape(count, -1), np.log(np.abs(paths).reshape(count, -1) + 0.1)]
    inward = twists[:, 3:]
    hints = np.concatenate([*hints, inward, np.log(np.abs(inward) + 0.02)], axis=1)
    paths, hints = (torch.from_numpy(each.astype(np.float32)) for each in (paths, hints))
    own = Measured(
        paths,
        torch.tensor([1.0, 1.0, 0.01, 0.01, 1.0])[:, None].expand(count, CANDIDATES, 3),
        torch.ones(count, CANDIDATES, dtype=torch.bool),
        torch.zeros(count),
        torch.full((count,), RADIUS),
        hints,
    )
    return own, labels


@pytest.fixture(scope="module")
def learned():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(motion, "EPOCHS", 12)
        return train_motion(*clips(4000), seed=0)


def test_it_learns_how_much_of_a_motion_is_missing(learned):
    own, labels = clips(600, seed=1)
    untrained = MotionNetwork(own.hints.shape[1]).eval()
    with torch.no_grad():
        before = motion_scores(untrained(own), labels)
    after = motion_scores(learned(own), labels)
    for name in ("turn way", "slide way", "press way", "both ways"):
        assert after[name] >= max(0.85, before[name] - 0.01), name
    for name in ("turn amount", "slide amount"):
        assert after[name] > before[name] + 0.1, name


def test_false_alarms_on_other_clips_are_as_rare_as_asked(learned):
    set_significance(learned, *clips(2000, seed=4))
    own, labels = clips(2000, seed=5)
    after = motion_scores(learned(own), labels)
    assert after["press false"] < 0.05
    assert after["press seen"] > 0.9


def test_spans_are_widened_to_hold_nine_in_ten(learned):
    narrow = MotionNetwork(learned.mean.numel())
    narrow.load_state_dict(learned.state_dict())
    narrow.eval().requires_grad_(False).widening *= 0.3
    widen_spans(narrow, *clips(600, seed=2))
    seen, labels = clips(600, seed=3)
    after = motion_scores(narrow(seen), labels)
    assert [after[f"{one} span"] for one in ("turn", "slide", "press")] == pytest.approx(
        [0.9] * 3, abs=0.1
    )


def test_the_same_seed_gives_the_same_network_and_leaves_the_global_one_alone(monkeypatch):
    monkeypatch.setattr(motion, "EPOCHS", 1)
    before = torch.random.get_rng_state()
    first, again = (train_motion(*clips(200), seed=3).state_dict() for _ in range(2))
    assert torch.equal(torch.random.get_rng_state(), before)
    assert all(torch.equal(again[name], value) for name, value in first.items())


def test_amounts_are_asked_where_they_can_be_read_or_are_at_rest():
    dim = (9.0, 0.5, 9.0)
    asked = [label(10.0, 3.0), label(10.0, 3.0, visible_grey=dim), label(visible_grey=dim)]
    asked.append(label(10.0, 3.0, motion=Motion.NONE))
    truths = Truths.of(asked)
    assert truths.turn_rad[:3].tolist() == pytest.approx([math.radians(10)] * 2 + [0.0])
    assert truths.slide_px[0].tolist() == [3.0, 0.0]
    assert truths.slide_px[:, 0].isnan().tolist() == [False, True, False, True]
    assert truths.readable[:, 1].nan_to_num(-1).tolist() == [1.0, 0.0, -1.0, -1.0]
    assert truths.moves[:, 1].nan_to_num(-1).tolist() == [1.0, -1.0, 0.0, 0.0]
    assert truths.contact.tolist() == [1.0, 1.0, 1.0, 0.0]


def test_where_nothing_is_asked_nothing_is_learned_and_nothing_breaks():
    seen, labels = clips(8)
    network = MotionNetwork(seen.hints.shape[1])
    nothing = Truths(*(value * torch.nan for value in vars(Truths.of(labels)).values()))
    loss = motion_network_loss(network(seen), nothing)
    loss.backward()
    assert loss.item() == 0
    assert all(not one.grad.any() for one in network.parameters())


def test_the_loss_is_least_at_the_truth_told_as_surely_as_it_is_right():
    seen, _ = clips(1)
    network = MotionNetwork(seen.hints.shape[1]).eval().requires_grad_(False)
    truths = Truths.of([label(10.0, 3.0, -4.0, 0.5)])
    path = torch.tensor([[math.radians(10.0) * RADIUS, 3.0, -4.0]])
    right = replace(network(seen), path=path, inward_mm=torch.tensor([0.5]))
    right = replace(right, deviation=torch.full((1, 4), 0.3), sense=torch.tensor([0.9]))
    least = motion_network_loss(right, truths)
    worse = [
        replace(right, path=path * torch.tensor([-1.0, 1.0, 1.0])),
        replace(right, path=path * torch.tensor([1.0, -1.0, 1.0])),
        replace(right, inward_mm=-right.inward_mm),
        replace(right, sense=1 - right.sense),
        replace(right, deviation=right.deviation * 9),
    ]
    assert all(motion_network_loss(one, truths) > least for one in worse)
