"""The odometer: its scale of amounts, and what it learns."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.odometry.movement import FLOOR, MOVEMENT_DIM
from geotlm_lm.odometry.odometer import AMOUNTS, SPANS, UNITS, Odometer, amounts, place_of
from geotlm_lm.training.odometry import _target, train_odometer, within_tolerance_share
from geotlm_lm.training.scoring import ClipSet


@pytest.mark.parametrize("unit", UNITS)
def test_amounts_lie_evenly_on_a_log_scale_within_their_span(unit):
    found = amounts(unit)
    assert len(found) == AMOUNTS
    assert SPANS[unit][0] < found[0] < found[-1] < SPANS[unit][1]
    steps = (found[1:] / found[:-1]).tolist()
    assert steps == pytest.approx([steps[0]] * (AMOUNTS - 1))
    assert place_of(found, unit).tolist() == pytest.approx(list(range(AMOUNTS)))


def test_what_is_learnt_is_a_bell_of_seven_tenths_of_a_cell_around_the_amount():
    amount = torch.tensor([7.0, 12.5, 20.0])
    unit = torch.tensor([0, 1, 0])
    bells = _target(unit, amount)
    cells = torch.arange(AMOUNTS, dtype=bells.dtype)
    middles = (bells * cells).sum(dim=1)
    places = [float(place_of(one, UNITS[kind])) for one, kind in zip(amount, unit, strict=True)]
    assert middles.tolist() == pytest.approx(places, abs=0.01)
    spread = (bells * (cells - middles[:, None]).square()).sum(dim=1).sqrt()
    assert spread.tolist() == pytest.approx([0.7] * 3, abs=0.01)


def clips(count, seed=0, scale=(0.1, 0.1)):
    """Turns and slides whose shear tells how far they go, up to a tenth."""
    rng = np.random.default_rng(seed)
    noise = torch.Generator().manual_seed(seed)
    movement, labels = torch.randn(count, MOVEMENT_DIM, generator=noise) * 0.1, []
    for row in range(count):
        amount = float(np.exp(rng.uniform(np.log(3), np.log(40))))
        is_turn = row % 2 == 0
        movement[row, 0 if is_turn else 1] = np.log(FLOOR + amount * np.exp(rng.normal(0, 0.05)))
        labels.append(
            MotionLabel(Motion.CLOCKWISE, rotation_deg=amount)
            if is_turn
            else MotionLabel(Motion.UP, slide_y_mm=-0.1 * amount, mm_per_px=scale)
        )
    token = torch.zeros(count, 1)
    return ClipSet(token, token, np.zeros(count), movement, labels, ["ball"] * count)


@pytest.fixture(scope="module")
def odometer():
    return train_odometer(clips(4000), seed=0)


def test_it_learns_how_far_unseen_clips_went(odometer):
    unseen = clips(300, seed=1)
    assert min(within_tolerance_share(odometer, unseen).values()) > 0.8
    shuffled = replace(unseen, movement=unseen.movement.roll(2, 0))
    assert max(within_tolerance_share(odometer, shuffled).values()) < 0.4


def test_its_probabilities_sum_to_one_and_lie_about_the_truth(odometer):
    seen = clips(300, seed=2)
    weights = odometer.read(seen.movement, "deg")
    assert weights.sum(dim=1).tolist() == pytest.approx([1.0] * 300, abs=1e-5)
    mean = (weights.double() * amounts("deg").log()).sum(dim=1).exp()[::2]
    true = torch.tensor([one.rotation_deg for one in seen.labels[::2]])
    assert (mean / true).log().abs().median() < 0.15


def test_the_same_seed_gives_the_same_odometer_and_leaves_the_global_one_alone():
    seen, before = clips(200), torch.random.get_rng_state()
    first, again = (train_odometer(seen, seed=3) for _ in range(2))
    assert torch.equal(torch.random.get_rng_state(), before)
    assert all(
        torch.equal(first.state_dict()[name], value) for name, value in again.state_dict().items()
    )
    assert not any(weight.requires_grad for weight in first.parameters())


def test_slides_of_unknown_scale_teach_nothing():
    unknown = clips(10, scale=None)
    with pytest.raises(ValueError, match="known amount"):
        train_odometer(unknown, seed=0)
    unknown = unknown.only(range(1, 10, 2))
    assert within_tolerance_share(Odometer().eval(), unknown) == {"deg": None, "px": None}
