"""What moves and is asked, around the thresholds of `core.twist`; losses worked out by hand."""

import math
from dataclasses import replace

import pytest
import torch

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import (
    AT_REST_MM,
    AT_REST_PX,
    COMPONENTS,
    MOVING_MM,
    MOVING_PX,
    Component,
    Twist,
)
from geotlm_lm.simulation.truth import READABLE_GREY
from geotlm_lm.training.truth import (
    MOTION_FLOOR_PX,
    MOTION_SHARPNESS,
    component_truth,
    counts_motion,
    motion_loss,
)

RADIUS = 20.0


def moving(component, path, visible_grey=(9.0, 9.0, 9.0)):
    """A label of one component that moves the imprint so far."""
    return MotionLabel(
        Motion.STILL,
        rotation_deg=-math.degrees(path / RADIUS) if component is Component.TURN else 0.0,
        depth_change_mm=path if component is Component.PRESS else 0.0,
        travel_px=(0.6 * path, -0.8 * path) if component is Component.SLIDE else (0.0, 0.0),
        contact_fraction=(0.1,) * 4,
        radius_px=RADIUS,
        visible_grey=visible_grey,
    )


@pytest.mark.parametrize("component", COMPONENTS)
def test_what_hardly_moves_is_not_graded(component):
    is_press = component is Component.PRESS
    rest, moving_from = (AT_REST_MM, MOVING_MM) if is_press else (AT_REST_PX, MOVING_PX)
    bands = [(0.9 * rest, False), (1.1 * rest, None), (0.9 * moving_from, None)]
    for path, expected in (*bands, (1.1 * moving_from, True), (9 * moving_from, True)):
        truth = component_truth(moving(component, path))
        assert truth.moves[component] is expected
        assert all(truth.moves[one] is False for one in COMPONENTS if one is not component)
        assert truth.twist.path(component, RADIUS) == pytest.approx(path)


@pytest.mark.parametrize("component", COMPONENTS)
def test_what_moves_unseen_is_not_asked_and_what_rests_still_is(component):
    dim = tuple(0.9 * READABLE_GREY if each is component else 9.0 for each in COMPONENTS)
    for path, expected in ((3.0, None), (0.0, False)):
        truth = component_truth(moving(component, path, dim))
        assert truth.moves[component] is expected
        assert truth.is_readable[component] is (expected is False)
        assert all(truth.is_readable[each] for each in COMPONENTS if each is not component)


def test_what_moves_barely_is_readable_where_it_would_be_if_it_went_a_pixel():
    for grey, expected in ((1.1, True), (0.9, False)):
        label = moving(Component.SLIDE, 0.5, (0.0, grey, 0.0))
        assert component_truth(label).is_readable[Component.SLIDE] is expected


def test_nothing_moves_on_an_untouched_gel():
    turning = moving(Component.TURN, 5.0)
    none = replace(turning, motion=Motion.NONE)
    for label in (none, replace(turning, contact_fraction=(0.0,) * 4)):
        truth = component_truth(label)
        assert (truth.is_touched, truth.twist) == (False, Twist())
        assert not any(truth.moves.values())
        assert not any(truth.is_readable.values())


def field(x_px, clips=1):
    return torch.tensor([x_px, 0.0]).expand(clips, 3, 3, 2).clone()


@pytest.mark.parametrize(("told", "true"), [(0.0, 5.0), (5.0, 0.0), (4.0, 5.0), (5.0, 5.0)])
def test_an_error_counts_relative_to_the_displacement_told_plus_true(told, true):
    error = MOTION_SHARPNESS * abs(told - true) / (MOTION_FLOOR_PX + told + true)
    expected = error - 0.25 if error >= 0.5 else error**2
    loss = motion_loss(field(told), field(true), torch.ones(1, 3, 3))
    assert float(loss) == pytest.approx(expected, abs=1e-6)


def test_what_is_told_outside_contact_or_of_a_clip_that_does_not_count_is_free():
    told, true = field(3.0, clips=2), field(3.0, clips=2)
    weight = torch.ones(2, 3, 3)
    weight[0, 0] = 0
    weight[1] = 0
    told[0, 0] = 50.0
    told[1] = 50.0
    assert float(motion_loss(told, true, weight)) == 0
    assert float(motion_loss(field(3.0), field(1.0), torch.zeros(1, 3, 3))) == 0


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
