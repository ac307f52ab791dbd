import numpy as np
import pytest

from geotlm_lm.simulation.contact import BOX_MM
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.profile import build_profile, pool_to_cells
from geotlm_lm.simulation.scene import Body

POSE = (1.5, -2.0, 0.7)


def test_a_tip_narrower_than_a_cell_does_not_vanish():
    fine = np.full((60, 60), 1000.0, np.float32)
    fine[24, 31] = 0.0
    cells = pool_to_cells(fine, 5)
    assert cells[4, 6] == 0.0
    assert (cells < 1).sum() == 1


def test_the_lowest_point_is_zero_whatever_the_lean_and_texture():
    body = Body("block", variant=5, tilt_x=0.1, tilt_y=-0.05, texture_um=30)
    fine = build_profile(body).sample((0.0, 0.0, 0.4), (0.08, 0.08), 320)
    assert fine.min() == pytest.approx(0, abs=0.02)
    assert fine.min() > -0.002


def test_turning_clockwise_takes_what_lies_right_down():
    profile = build_profile(Body("letter_l", variant=1))
    plain = profile.sample((0.0, 0.0, 0.0), (0.1, 0.1), 101)
    turned = profile.sample((0.0, 0.0, np.pi / 2), (0.1, 0.1), 101)
    # A quarter turn x -> y: the value at (x, y) = (a, 0) goes to (0, a); rot90 with k=-1 in arrays.
    assert np.abs(np.clip(turned, 0, 1) - np.clip(np.rot90(plain, -1), 0, 1)).mean() < 0.01


def test_moving_right_moves_the_body_to_higher_columns():
    profile = build_profile(Body("letter_l", variant=1))
    plain = np.clip(profile.sample((0.0, 0.0, 0.3), (0.1, 0.1), 120), 0, 1)
    moved = np.clip(profile.sample((1.0, -0.5, 0.3), (0.1, 0.1), 120), 0, 1)
    assert np.abs(moved[:-5, 10:] - plain[5:, :-10]).max() < 0.02


@pytest.mark.parametrize("name", TRAINING_OBJECTS)
def test_outside_its_window_a_body_is_higher_than_asked_for(name):
    profile = build_profile(Body(name, variant=3, tilt_x=0.08))
    whole = profile.sample(POSE, (0.08, 0.07), 224)
    window = profile.window(POSE, (0.08, 0.07), 224, 0.7)
    low = whole < 0.7
    low[window.slices] = False
    assert not low.any()
    # Whole sixteenths of a raster sample, on which the interpolation places its points, apart.
    part = profile.sample(POSE, (0.08, 0.07), 224, window)
    assert np.abs(np.minimum(part, 1) - np.minimum(whole[window.slices], 1)).mean() < 1e-3


def test_a_compact_body_needs_a_small_window_and_one_out_of_view_none():
    profile = build_profile(Body("ball_small"))
    window = profile.window((0.0, 0.0, 0.0), (0.08, 0.08), 224, 0.5)
    assert 0 < (window.bottom - window.top) * (window.right - window.left) < 0.2 * 224**2
    away = profile.window((500.0, 0.0, 0.0), (0.08, 0.08), 224, 0.5)
    assert away.left == away.right
    assert profile.on_cells((500.0, 0.0, 0.0), BOX_MM, 48, 0.5).min() > 500


@pytest.mark.parametrize("name", ["key", "ball_medium", "cloth_coarse"])
def test_cells_within_reach_are_the_same_from_a_window(name):
    profile = build_profile(Body(name, variant=3))
    whole, part = (profile.on_cells(POSE, BOX_MM, 48, reach) for reach in (np.inf, 1.0))
    assert np.abs(np.minimum(part, 0.8) - np.minimum(whole, 0.8)).max() < 0.01
