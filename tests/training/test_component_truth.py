"""What counts, what does not and what is not asked, around the thresholds of `core.twist`."""

import math
from dataclasses import replace

import pytest

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import (
    COMPONENTS,
    COUNTING_MM,
    COUNTING_PX,
    STILL_MM,
    STILL_PX,
    Component,
    Twist,
)
from geotlm_lm.simulation.truth import READABLE_GREY
from geotlm_lm.training.component_truth import component_truth

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
def test_between_still_and_counting_nothing_is_asked(component):
    still, counting = {Component.PRESS: (STILL_MM, COUNTING_MM)}.get(
        component, (STILL_PX, COUNTING_PX)
    )
    bands = [(0.9 * still, False), (1.1 * still, None), (0.9 * counting, None)]
    for path, expected in (*bands, (1.1 * counting, True), (9 * counting, True)):
        truth = component_truth(moving(component, path))
        assert truth.counts[component] is expected
        assert all(truth.counts[one] is False for one in COMPONENTS if one is not component)
        assert truth.twist.path(component, RADIUS) == pytest.approx(path)


@pytest.mark.parametrize("component", COMPONENTS)
def test_what_counts_but_cannot_be_seen_is_not_asked_and_what_does_not_count_still_is(component):
    dim = tuple(0.9 * READABLE_GREY if one is component else 9.0 for one in COMPONENTS)
    for path, counts in ((3 * COUNTING_PX, None), (0.0, False)):
        truth = component_truth(moving(component, path, dim))
        assert truth.counts[component] is counts
        assert not truth.is_readable[component]
        assert all(truth.is_readable[one] for one in COMPONENTS if one is not component)


def test_an_untouched_gel_counts_nothing():
    turning = moving(Component.TURN, 5.0)
    none = replace(turning, motion=Motion.NONE)
    for label in (none, replace(turning, contact_fraction=(0.0,) * 4)):
        truth = component_truth(label)
        assert (truth.is_touched, truth.twist) == (False, Twist())
        assert not any(truth.counts.values())
        assert not any(truth.is_readable.values())
