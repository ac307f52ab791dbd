"""Laws of the sign convention."""

import pytest

from geotlm_lm.core.labels import (
    DIRECTED,
    ROTATIONS,
    SLIDES,
    Motion,
    MotionLabel,
    mirror,
    motion_class,
    reverse,
    signed_amount,
    turn_by_quarter,
)


@pytest.mark.parametrize("change", [mirror, reverse])
@pytest.mark.parametrize("motion", Motion)
def test_mirroring_and_reversing_twice_change_nothing(change, motion):
    assert change(change(motion)) == motion


@pytest.mark.parametrize("motion", Motion)
def test_mirroring_and_reversing_commute(motion):
    assert mirror(reverse(motion)) == reverse(mirror(motion))


@pytest.mark.parametrize("motion", DIRECTED)
def test_every_direction_turns_around_when_played_backwards(motion):
    assert reverse(motion) != motion
    assert motion_class(reverse(motion)) == motion_class(motion)


@pytest.mark.parametrize("motion", Motion)
def test_a_mirror_swaps_only_what_has_a_left_and_a_right(motion):
    is_handed = motion in (*ROTATIONS, Motion.LEFT, Motion.RIGHT)
    assert (mirror(motion) != motion) == is_handed


def test_a_label_survives_json_values():
    label = MotionLabel(Motion.CLOCKWISE, rotation_deg=3.5, contact_fraction=(0.0, 0.25))
    assert MotionLabel.from_dict(label.to_dict()) == label
    assert label.to_dict()["motion"] == "clockwise"


@pytest.mark.parametrize("motion", [*DIRECTED, Motion.PRESS, Motion.RELEASE])
def test_a_movement_goes_its_own_way_and_against_the_reversed_one(motion):
    amounts = {"turn": 1.0, "right": 2.0, "down": 3.0, "inward": 4.0}
    assert abs(signed_amount(motion, **amounts)) in amounts.values()
    assert signed_amount(reverse(motion), **amounts) == -signed_amount(motion, **amounts)


def test_clockwise_right_down_and_inward_are_positive():
    assert signed_amount(Motion.CLOCKWISE, turn=1, right=0, down=0) == 1
    assert signed_amount(Motion.RIGHT, turn=0, right=1, down=0) == 1
    assert signed_amount(Motion.DOWN, turn=0, right=0, down=1) == 1
    assert signed_amount(Motion.PRESS, turn=0, right=0, down=0, inward=1) == 1


@pytest.mark.parametrize("motion", [Motion.STILL, Motion.NONE])
def test_stillness_and_absence_go_no_way(motion):
    assert signed_amount(motion, turn=1, right=1, down=1, inward=1) is None


@pytest.mark.parametrize("motion", Motion)
def test_two_quarters_turn_a_slide_around_and_leave_everything_else(motion):
    turned = turn_by_quarter(turn_by_quarter(motion))
    assert turned == (reverse(motion) if motion in SLIDES else motion)
    assert motion_class(turn_by_quarter(motion)) == motion_class(motion)


def test_a_picture_turned_counterclockwise_sends_right_up():
    assert turn_by_quarter(Motion.RIGHT) is Motion.UP


LABELS = [
    MotionLabel(Motion.CLOCKWISE, rotation_deg=7.0, slide_x_mm=0.2, slide_y_mm=-0.1),
    MotionLabel(Motion.LEFT, rotation_deg=-1.0, slide_x_mm=-2.0, slide_y_mm=0.3),
    MotionLabel(Motion.UP, rotation_deg=2.0, slide_x_mm=0.1, slide_y_mm=-1.5),
    MotionLabel(Motion.PRESS, depth_change_mm=0.4),
]


@pytest.mark.parametrize("label", LABELS)
def test_a_mirrored_clip_goes_as_far_the_way_its_label_names(label):
    def far(one):
        way = {"turn": one.rotation_deg, "right": one.slide_x_mm, "down": one.slide_y_mm}
        return signed_amount(one.motion, **way, inward=one.depth_change_mm)

    mirrored = label.mirrored()
    assert far(mirrored) == far(label) > 0
    assert (mirrored.rotation_deg, mirrored.slide_x_mm) == (-label.rotation_deg, -label.slide_x_mm)
    assert mirrored.slide_y_mm == label.slide_y_mm
    assert mirrored.mirrored() == label


def test_a_slide_has_pixels_where_it_is_known_how_wide_and_how_high_they_are():
    label = MotionLabel(Motion.RIGHT, slide_x_mm=0.3, slide_y_mm=-0.2, mm_per_px=(0.1, 0.05))
    assert label.slide_px == pytest.approx(5)  # 3 across and 4 down
    assert MotionLabel(Motion.RIGHT, slide_x_mm=0.3).slide_px is None
