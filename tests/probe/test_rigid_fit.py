import numpy as np
import pytest

from geotlm_lm.probe.rigid_fit import fit_rigid, radius_of_gyration


def test_a_rigid_field_is_recovered_exactly():
    rows, columns, turn, slide = 40, 50, 0.3, np.array([1.5, -2.0])
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    weight = np.random.default_rng(0).random((rows, columns)).astype(np.float32)
    arm_x, arm_y = x - np.average(x, weights=weight), y - np.average(y, weights=weight)
    turned_x = np.cos(turn) * arm_x - np.sin(turn) * arm_y
    turned_y = np.sin(turn) * arm_x + np.cos(turn) * arm_y
    field = np.stack([turned_x - arm_x, turned_y - arm_y], axis=-1) + slide.astype(np.float32)
    assert fit_rigid(field, weight) == pytest.approx((turn, *slide), abs=1e-4)


def test_reweighting_ignores_a_patch_that_does_not_turn_along():
    y, x = np.mgrid[:60, :60].astype(np.float32) - 30
    field = np.stack([-0.05 * y, 0.05 * x], axis=-1)
    field[:15, :15] = (6.0, 6.0)
    weight = np.ones((60, 60), np.float32)
    plain, robust = (abs(fit_rigid(field, weight, n)[0] - 0.05) for n in (0, 4))
    assert robust < 0.2 * plain


def test_the_radius_of_gyration_of_a_bar_is_its_length_over_the_root_of_twelve():
    bar = np.zeros((5, 300), np.float32)
    bar[2, 40:240] = 1
    assert radius_of_gyration(bar) == pytest.approx(200 / 12**0.5, rel=1e-4)


def test_the_radius_of_gyration_of_a_plate_counts_both_of_its_sides():
    plate = np.zeros((200, 300), np.float32)
    plate[20:180, 40:240] = 1
    assert radius_of_gyration(plate) == pytest.approx((160**2 + 200**2) ** 0.5 / 12**0.5, rel=1e-3)
