"""Laws of the sign convention."""

import pytest

from geotlm_lm.core.labels import (
    DIRECTED,
    ROTATIONS,
    Motion,
    MotionLabel,
    mirror,
    motion_class,
    relation,
    reverse,
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


@pytest.mark.parametrize("motion", Motion)
def test_a_motion_is_the_same_as_itself_and_cannot_be_told_from_nothing(motion):
    assert relation(motion, motion) == "same"
    assert relation(motion, None) == relation(None, motion) == "cannot tell"


@pytest.mark.parametrize("motion", [*DIRECTED, Motion.PRESS, Motion.RELEASE])
def test_what_is_played_backwards_is_opposite(motion):
    assert relation(motion, reverse(motion)) == relation(reverse(motion), motion) == "opposite"


@pytest.mark.parametrize("pair", [(Motion.UP, Motion.LEFT), (Motion.CLOCKWISE, Motion.PRESS)])
def test_motions_of_other_axes_are_different(pair):
    assert relation(*pair) == "different"
