"""A touch's numbers are the clip's truth; expected values are the numbers themselves."""

import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.touch import Touch, simulate_touch


@pytest.mark.parametrize(
    ("numbers", "motion"),
    [
        ({"twist_deg": 20.0}, Motion.CLOCKWISE),
        ({"slide_x_mm": -1.0, "slide_y_mm": 0.4}, Motion.LEFT),
        ({"object_name": "bead", "slide_y_mm": -0.5, "twist_deg": 12.0}, Motion.UP),
        ({"object_name": "coin", "slide_y_mm": -0.5, "twist_deg": 12.0}, Motion.CLOCKWISE),
        ({"press_mm": 0.3}, Motion.PRESS),
        ({"press_mm": -1.4, "slide_y_mm": 0.02}, Motion.RELEASE),
        ({}, Motion.STILL),
        ({"depth_mm": -0.2, "twist_deg": 20.0}, Motion.NONE),
    ],
)
def test_a_touch_is_named_by_its_greater_path_at_its_own_contact(numbers, motion):
    assert Touch(**numbers).motion is motion


@pytest.mark.parametrize("name", ["key", "corner", "cable"])
@pytest.mark.parametrize("move", [(20.0, 0.8, -0.2, 0.1), (-60.0, -5.0, 5.0, 0.8), (35.0, 0, 0, 0)])
def test_the_label_holds_the_numbers_asked_for(name, move):
    made = simulate_touch(Touch(name, 0.6, *move, seed=3), with_drift=False)
    twist, size = made.twist, made.mm_per_px
    numbers = (twist.turn_deg, twist.right_px * size[0], twist.down_px * size[1], twist.inward_mm)
    assert numbers == pytest.approx(move, abs=0.02)
    assert min(made.label.contact_fraction) > 0


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ({"twist_deg": 90.0}, r"twist_deg is 90, expected -60 to 60\."),
        ({"depth_mm": float("nan")}, r"depth_mm is nan, expected -1 to 1\.5\."),
    ],
)
def test_what_cannot_be_simulated_is_told(numbers, sentence):
    with pytest.raises(UsageError, match=sentence):
        Touch(**numbers)
