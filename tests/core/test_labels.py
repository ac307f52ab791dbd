"""Laws of the sign convention."""

import pytest

from geotlm_lm.core.edit import opposite
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel, signed_amount


def test_a_label_survives_json_values():
    label = MotionLabel(Motion.CLOCKWISE, rotation_deg=3.5, contact_fraction=(0.0, 0.25))
    assert MotionLabel.from_dict(label.to_dict()) == label
    assert label.to_dict()["motion"] == "clockwise"


@pytest.mark.parametrize("motion", [*DIRECTED, Motion.PRESS, Motion.RELEASE])
def test_a_movement_goes_its_own_way_and_against_the_reversed_one(motion):
    amounts = {"turn": 1.0, "right": 2.0, "down": 3.0, "inward": 4.0}
    positive = {"clockwise": 1, "right": 2, "down": 3, "press": 4}
    assert signed_amount(motion, **amounts) == positive.get(
        motion, -positive.get(opposite(motion), 0)
    )
    assert signed_amount(opposite(motion), **amounts) == -signed_amount(motion, **amounts)


@pytest.mark.parametrize("motion", [Motion.STILL, Motion.NONE])
def test_stillness_and_absence_go_no_way(motion):
    assert signed_amount(motion, turn=1, right=1, down=1, inward=1) is None


def test_a_slide_has_pixels_where_it_is_known_how_wide_and_how_high_they_are():
    label = MotionLabel(Motion.RIGHT, slide_x_mm=0.3, slide_y_mm=-0.2, mm_per_px=(0.1, 0.05))
    assert label.slide_px == pytest.approx(5)  # 3 across and 4 down
    assert MotionLabel(Motion.RIGHT, slide_x_mm=0.3).slide_px is None


def test_the_amount_of_a_motion_is_positive_in_its_own_unit():
    turned = MotionLabel(Motion.COUNTERCLOCKWISE, rotation_deg=-15.0, slide_y_mm=1.0)
    assert turned.amount == 15.0
    slid = MotionLabel(Motion.UP, rotation_deg=9.0, slide_y_mm=-1.4, mm_per_px=(0.1, 0.07))
    assert slid.amount == pytest.approx(20.0)
    assert MotionLabel(Motion.UP, slide_y_mm=-1.4).amount is None
    assert MotionLabel(Motion.PRESS, depth_change_mm=0.7).amount is None
