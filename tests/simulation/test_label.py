import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.label import (
    Trace,
    image_change,
    is_readable,
    label_for,
    margin_grey,
    motion_at_contact_mm,
    motion_products,
    patch_displacement,
    patch_means,
)
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene

TOUCHED = np.ones((2, 14, 14), np.float32)


def scene(**path):
    still = {"depth_mm": (0.5, 0.5), "x_mm": (0, 0), "y_mm": (0, 0), "rotation_rad": (0, 0)}
    return Scene(Body("block"), Path(**still | path), Motion.STILL, optics=Optics(0.1, 0.05))


def test_a_slide_moves_every_touched_patch_by_its_pixels():
    moved = patch_displacement(scene(x_mm=(0.0, 1.0), y_mm=(0.0, -0.5)), TOUCHED)
    assert not moved[0].any()
    assert moved[1].reshape(-1, 2) == pytest.approx(np.tile([10.0, -10.0], (196, 1)), abs=1e-4)


def test_a_clockwise_turn_moves_the_top_right_and_the_right_down():
    moved = patch_displacement(scene(rotation_rad=(1.0, 1.1)), TOUCHED)
    assert moved[1, 0, :, 0].min() > 0
    assert moved[1, -1, :, 0].max() < 0
    assert moved[1, :, -1, 1].min() > 0
    assert moved[1, :, 0, 1].max() < 0


def test_a_patch_moves_as_the_rotation_matrix_says():
    angle, centre = 0.3, (1.0, -2.0)
    path = {"x_mm": (1.0, 1.0), "y_mm": (-2.0, -2.0), "rotation_rad": (0.0, angle)}
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


def test_patch_means_average_sixteen_by_sixteen():
    image = np.zeros((1, 224, 224), np.float32)
    image[0, 16:32, 32:40] = 1
    assert patch_means(image)[0, 1, 2] == 0.5
    assert patch_means(image).sum() == 0.5


def test_image_change_is_the_rms_over_the_contact_only():
    first = np.zeros((3, 224, 224), np.float32)
    last = first.copy()
    touches = np.zeros((224, 224), bool)
    touches[:10] = True
    last[:, :10], last[:, 10:] = 3, 99
    assert image_change(first, last, touches) == pytest.approx(3)
    assert image_change(first, last, touches & False) == 0


@pytest.mark.parametrize(
    ("motion", "contact", "trace", "expected"),
    [
        (Motion.CLOCKWISE, 0.1, Trace(1.9, turn_mm=1.0), False),
        (Motion.CLOCKWISE, 0.1, Trace(2.1, turn_mm=1.0), True),
        (Motion.CLOCKWISE, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=1.1), False),
        (Motion.LEFT, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=1.1), True),
        (Motion.LEFT, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=0.9), False),
        (Motion.LEFT, 0.001, Trace(9.0, slide_mm=1.0), False),
        (Motion.LEFT, 0.1, Trace(9.0, slide_mm=1.0, margin_grey=1.9), False),
        (Motion.LEFT, 0.1, Trace(9.0, slide_mm=1.0, margin_grey=2.1), True),
        (Motion.PRESS, 0.1, Trace(9.0), True),
        (Motion.STILL, 0.1, Trace(), True),
        (Motion.NONE, 0.0, Trace(), True),
    ],
)
def test_a_motion_is_readable_when_it_beats_the_noise_and_the_lesser_one(
    motion, contact, trace, expected
):
    assert is_readable(motion, np.full(4, contact), trace) is expected


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


def test_a_label_until_an_earlier_frame_counts_to_that_frame():
    path = {"x_mm": (0.0, 1.0, 2.0), "y_mm": (0, 0, 0), "rotation_rad": (0.0, 0.1, 0.2)}
    moving = scene(depth_mm=(0.5, 0.4, 0.3), **path)
    label = label_for(moving, np.full(2, 0.1), Trace(), last=1)
    assert (label.slide_x_mm, label.depth_change_mm) == pytest.approx((1.0, -0.1))
    assert label.rotation_deg == pytest.approx(np.degrees(0.1))


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
