"""What can be seen of a motion, on pictures whose slopes are known."""

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene
from geotlm_lm.simulation.trace import (
    image_change,
    margin_grey,
    motion_at_contact_mm,
    motion_products,
)


def scene(**path):
    still = {"depth_mm": (0.5, 0.5), "x_mm": (0, 0), "y_mm": (0, 0), "rotation_rad": (0, 0)}
    return Scene(Body("block"), Path(**still | path), Motion.STILL, optics=Optics(0.1, 0.05))


def test_image_change_is_the_rms_over_the_contact_only():
    first = np.zeros((3, 224, 224), np.float32)
    last = first.copy()
    touches = np.zeros((224, 224), bool)
    touches[:10] = True
    last[:, :10], last[:, 10:] = 3, 99
    assert image_change(first, last, touches) == pytest.approx(3)
    assert image_change(first, last, touches & False) == 0


def test_a_turn_about_the_contact_turns_it_and_one_about_a_far_axis_carries_it_along():
    contact = np.zeros((224, 224), bool)
    contact[92:132, 102:122] = True  # 2 mm x 2 mm around the middle
    gyration = 2 / np.sqrt(6)
    x, y, turn, _ = motion_at_contact_mm(scene(rotation_rad=(0.0, 0.2)), contact, 1)
    assert (turn, np.hypot(x, y)) == pytest.approx((0.2 * gyration, 0.0), abs=0.002)
    far = scene(x_mm=(5.0, 5.0), rotation_rad=(0.0, -0.2))
    x, y, turn, _ = motion_at_contact_mm(far, contact, 1)
    assert (-turn, np.hypot(x, y)) == pytest.approx(
        (0.2 * gyration, 2 * 5 * np.sin(0.1)), abs=0.002
    )
    assert y > 0.99  # the axis lies to the right: what is left of it goes down as it turns back


def picture(wave):
    """Return a planar frame whose three channels are `wave` of x and y in mm, and a square."""
    axis = np.arange(224) - 111.5
    x, y = np.meshgrid(axis * 0.1, axis * 0.05)
    contact = np.zeros((224, 224), bool)
    contact[72:152, 92:132] = True  # 4 mm x 4 mm
    return np.stack([wave(x, y)] * 3).astype(np.float32), contact


def margin(wave, motion_mm, motion):
    clean, contact = picture(wave)
    *_, middle = motion_at_contact_mm(scene(), contact, 1)
    return margin_grey(
        motion_products(clean, contact, scene(), middle), np.array(motion_mm), motion
    )


def test_small_motions_change_the_picture_as_the_products_say():
    clean, contact = picture(lambda x, y: 10 * x + 3 * y)
    *_, middle = motion_at_contact_mm(scene(), contact, 1)
    products = motion_products(clean, contact, scene(), middle)
    assert products[:2, :2] == pytest.approx(np.array([[100, 30], [30, 9]]), rel=1e-3)


def test_an_edge_sliding_along_itself_cannot_be_named():
    def edge(x, y):
        return 50 * np.tanh(x - y)

    # Half a millimetre to the right, or as well up: the edge looks the same.
    assert margin(edge, (0.5, 0.0, 0.0), Motion.RIGHT) < 0.05


def test_a_pattern_in_both_directions_is_told_by_the_angle_to_the_next_name():
    def pattern(x, y):
        return 20 * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)

    grey_per_mm = 20 * 2 * np.pi / 2
    told = margin(pattern, (0.1, 0.0, 0.0), Motion.RIGHT)
    assert told == pytest.approx(0.1 * grey_per_mm * np.sin(np.pi / 4), rel=0.1)
    turned = margin(pattern, (0.1, 0.0, 0.09), Motion.RIGHT)
    assert turned < 0.3 * told


def test_a_turn_of_what_looks_the_same_all_around_cannot_be_named():
    assert margin(lambda x, y: x**2 + y**2, (0.0, 0.0, 0.3), Motion.CLOCKWISE) < 0.1
