"""Expected values: losses worked out by hand for constant fields."""

from dataclasses import replace

import pytest
import torch

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.training.motion_loss import (
    MOTION_FLOOR_PX,
    MOTION_SHARPNESS,
    counts_motion,
    motion_loss,
)


def field(x_px, clips=1):
    return torch.tensor([x_px, 0.0]).expand(clips, 3, 3, 2).clone()


@pytest.mark.parametrize(("told", "true"), [(0.0, 5.0), (5.0, 0.0), (4.0, 5.0), (5.0, 5.0)])
def test_an_error_counts_relative_to_the_displacement_told_plus_true(told, true):
    error = MOTION_SHARPNESS * abs(told - true) / (MOTION_FLOOR_PX + told + true)
    expected = error - 0.25 if error >= 0.5 else error**2
    loss = motion_loss(field(told), field(true), torch.ones(1, 3, 3))
    assert float(loss) == pytest.approx(expected, abs=1e-6)


def test_a_large_motion_counts_little_more_than_a_small_one():
    weight = torch.ones(1, 3, 3)
    small = motion_loss(field(0.0), field(3.0), weight)
    large = motion_loss(field(0.0), field(60.0), weight)
    assert 1 < large / small < 1.5


def test_what_is_told_outside_contact_or_of_a_clip_that_does_not_count_is_free():
    told, true = field(3.0, clips=2), field(3.0, clips=2)
    weight = torch.ones(2, 3, 3)
    weight[0, 0] = 0
    weight[1] = 0
    told[0, 0] = 50.0
    told[1] = 50.0
    assert float(motion_loss(told, true, weight)) == 0


def test_nothing_touched_costs_nothing():
    loss = motion_loss(field(3.0), field(1.0), torch.zeros(1, 3, 3))
    assert float(loss) == 0


TURNING = MotionLabel(
    Motion.CLOCKWISE, rotation_deg=8.0, radius_px=20.0, visible_grey=(9.0, 9.0, 9.0)
)
PRESSING = replace(TURNING, motion=Motion.PRESS, rotation_deg=0.0, depth_change_mm=0.4)


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        (TURNING, True),
        (replace(TURNING, depth_change_mm=0.4, travel_px=(5.0, 0.0)), True),
        (MotionLabel(Motion.STILL), True),
        (MotionLabel(Motion.NONE), True),
        # The imprint of a press spreads, although its object stays.
        (PRESSING, False),
        (replace(PRESSING, depth_change_mm=-0.4), False),
        # What slides unseen beside a turn would be asked too.
        (replace(TURNING, travel_px=(5.0, 0.0), visible_grey=(9.0, 0.5, 9.0)), False),
        (replace(TURNING, visible_grey=(0.5, 9.0, 9.0)), False),
    ],
)
def test_which_clips_have_a_displacement_to_learn(label, expected):
    assert counts_motion(label) is expected
