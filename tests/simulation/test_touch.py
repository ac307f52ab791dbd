"""A touch's numbers are the clip's truth; expected values are the numbers themselves."""

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.touch import Touch, simulate_touch


@pytest.mark.parametrize(
    ("numbers", "motion"),
    [
        ({"twist_deg": 20.0}, Motion.CLOCKWISE),
        ({"twist_deg": -20.0, "slide_x_mm": 0.2}, Motion.COUNTERCLOCKWISE),
        ({"slide_x_mm": -1.0, "slide_y_mm": 0.4}, Motion.LEFT),
        ({"slide_y_mm": 1.0}, Motion.DOWN),
        ({"slide_y_mm": -0.5, "twist_deg": 12.0}, Motion.UP),  # the turn's path is 0.42 mm
        ({"slide_y_mm": 0.3, "twist_deg": -12.0}, Motion.COUNTERCLOCKWISE),
        ({}, Motion.STILL),
        ({"depth_mm": -0.2, "twist_deg": 20.0}, Motion.NONE),
    ],
)
def test_a_touch_is_named_by_its_greater_path(numbers, motion):
    assert Touch(**numbers).motion is motion


def test_the_label_holds_the_numbers_asked_for():
    made = simulate_touch(Touch("key", twist_deg=12.0, slide_x_mm=0.1, seed=3))
    assert made.label.motion is Motion.CLOCKWISE
    assert made.label.rotation_deg == pytest.approx(12.0)
    assert made.label.slide_x_mm == pytest.approx(0.1)
    assert made.clip.frames.shape == (4, 224, 224, 3)
    assert made.depth_mm.max() > 0.1
    assert made.drift_px is not None


def test_the_same_touch_is_the_same_clip_and_another_seed_another():
    first, again, other = (simulate_touch(Touch("key", seed=s)).clip.frames for s in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ({"object_name": "unicorn"}, "There is no shape 'unicorn', expected one of "),
        ({"twist_deg": 90.0}, r"twist_deg is 90, expected -40 to 40\."),
        ({"depth_mm": float("nan")}, r"depth_mm is nan, expected -1 to 1\.5\."),
    ],
)
def test_what_cannot_be_simulated_is_told(numbers, sentence):
    with pytest.raises(UsageError, match=sentence):
        Touch(**numbers)
