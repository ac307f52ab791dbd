import numpy as np
import pytest

from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import Component
from geotlm_lm.simulation.label import (
    components_of,
    is_readable,
    label_for,
    patch_displacement,
    twist_of,
)
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene
from geotlm_lm.simulation.trace import Trace

TOUCHED = np.ones((2, 14, 14), np.float32)


def scene(**path):
    still = {"depth_mm": (0.5, 0.5), "x_mm": (0, 0), "y_mm": (0, 0), "rotation_rad": (0, 0)}
    return Scene(Body("block"), Path(**still | path), Motion.STILL, optics=Optics(0.1, 0.05))


def test_a_slide_moves_every_touched_patch_by_its_pixels():
    moved = patch_displacement(scene(x_mm=(0.0, 1.0), y_mm=(0.0, -0.5)), TOUCHED)
    assert not moved[0].any()
    assert moved[1].reshape(-1, 2) == pytest.approx(np.tile([10.0, -10.0], (196, 1)), abs=1e-4)


def test_a_patch_moves_as_the_rotation_matrix_says():
    angle, centre = 0.3, (1.0, -0.7)
    path = {"x_mm": (1.0, 1.0), "y_mm": (-0.7, -0.7), "rotation_rad": (0.0, angle)}
    moved = patch_displacement(scene(**path), TOUCHED)[1, 4, 11]
    here = np.array([(11.5 * 16 - 112) * 0.1, (4.5 * 16 - 112) * 0.05])
    back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    was = np.array(centre) + back @ (here - centre)
    assert moved == pytest.approx((here - was) / (0.1, 0.05), abs=1e-3)


def test_patches_without_contact_do_not_move():
    contact = TOUCHED.copy()
    contact[1, 3] = 0
    moved = patch_displacement(scene(x_mm=(0.0, 1.0)), contact)
    assert not moved[1, 3].any()
    assert moved[1, 4].any()


@pytest.mark.parametrize(
    ("motion", "contact", "trace", "expected"),
    [
        (Motion.CLOCKWISE, 0.1, Trace(1.9, turn_mm=1.0), False),
        (Motion.CLOCKWISE, 0.1, Trace(2.1, turn_mm=1.0), True),
        (Motion.CLOCKWISE, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=1.1), False),
        (Motion.LEFT, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=1.1), True),
        (Motion.LEFT, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=0.9), False),
        (Motion.LEFT, 0.001, Trace(9.0, slide_mm=1.0), False),
        (Motion.PRESS, 0.1, Trace(9.0), True),
        (Motion.STILL, 0.1, Trace(), True),
        (Motion.NONE, 0.0, Trace(), True),
    ],
)
def test_a_motion_is_readable_when_it_beats_the_noise_and_the_lesser_one(
    motion, contact, trace, expected
):
    assert is_readable(motion, np.full(4, contact), trace) is expected


def test_a_label_until_an_earlier_frame_counts_to_that_frame():
    path = {"x_mm": (0.0, 1.0, 2.0), "y_mm": (0, 0, 0), "rotation_rad": (0.0, 0.1, 0.2)}
    moving = scene(depth_mm=(0.5, 0.4, 0.3), **path)
    label = label_for(moving, np.full(2, 0.1), Trace(), last=1)
    assert (label.slide_x_mm, label.depth_change_mm) == pytest.approx((1.0, -0.1))
    assert label.rotation_deg == pytest.approx(np.degrees(0.1))


def test_a_label_tells_the_travel_both_ways_and_the_pixels_it_takes():
    path = {"x_mm": (0.2, -0.1), "y_mm": (0.5, 0.7), "rotation_rad": (0.3, 0.1)}
    label = label_for(scene(**path), np.full(2, 0.1), Trace())
    assert (label.slide_x_mm, label.slide_y_mm) == pytest.approx((-0.3, 0.2))
    assert label.rotation_deg == pytest.approx(-np.degrees(0.2))
    assert label.slide_px == pytest.approx(5.0)  # 3 pixels of 0.1 mm across, 4 of 0.05 mm down


def test_a_mirrored_label_tells_the_mirrored_twist_and_the_same_of_what_counts():
    path = {"x_mm": (0.2, -0.1), "rotation_rad": (0.3, 0.1), "depth_mm": (0.4, 0.6)}
    trace = Trace(travel_px=(-3.0, 4.0), radius_px=20.0, visible_grey=(9.0, 1.0, 0.0))
    label = label_for(scene(**path), np.full(2, 0.1), trace)
    assert twist_of(MIRRORED.of_label(label)) == MIRRORED.of_twist(twist_of(label))
    told, mirrored = components_of(label), components_of(MIRRORED.of_label(label))
    assert [one.counts for one in told.values()] == [True, True, True]
    assert [one.is_visible for one in told.values()] == [True, False, False]
    ways = [
        (one.way, other.way) for one, other in zip(told.values(), mirrored.values(), strict=True)
    ]
    assert ways[0] == (Motion.COUNTERCLOCKWISE, Motion.CLOCKWISE)
    assert ways[1:] == [(Motion.DOWN, Motion.DOWN), (Motion.PRESS, Motion.PRESS)]


def test_what_moves_the_imprint_by_less_than_noise_does_not_count():
    label = MotionLabel(Motion.STILL, rotation_deg=2.0, travel_px=(0.5, 0.0), radius_px=10.0)
    counting = {component: one.counts for component, one in components_of(label).items()}
    assert counting == {Component.TURN: False, Component.SLIDE: None, Component.PRESS: False}
    with pytest.raises(ValueError, match="tells no twist"):
        twist_of(MotionLabel(Motion.LEFT, slide_x_mm=-1.0))
