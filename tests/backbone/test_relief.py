"""Expected values: the shading of a known relief under the lights of GelSight Mini."""

import numpy as np
import pytest

from geotlm_lm.backbone.relief import RELIEF_SIDE, SHADE_X, SHADE_Y, is_inside_out, reliefs

MIDDLE = (RELIEF_SIDE - 1) / 2


def places():
    return np.mgrid[:RELIEF_SIDE, :RELIEF_SIDE] - MIDDLE


def bump(radius_px):
    rows, columns = places()
    return np.exp(-(rows**2 + columns**2) / (2 * radius_px**2)).astype(np.float32)


def shaded(relief):
    """Shade a relief as the simulator does, with slopes s = -grad d."""
    slope_y, slope_x = (-one for one in np.gradient(relief))
    red = -0.6 * slope_y
    return np.stack([red, SHADE_X * slope_x, red + SHADE_Y * slope_y], axis=-1).astype(np.float32)


@pytest.mark.parametrize("radius_px", [1.5, 3])
def test_a_bump_is_integrated_from_its_shading(radius_px):
    relief = 100 * bump(radius_px)
    (found,) = reliefs([shaded(relief)])
    assert np.corrcoef(found.ravel(), relief.ravel())[0, 1] > 0.9
    # Long waves are damped, so that a peak comes out a little lower, never of another sign.
    assert 0.55 < found.max() / relief.max() < 1.05


def test_a_squashed_picture_gives_the_relief_of_the_gel():
    """The shade tells slopes on the gel, where a column is 4/3 as wide as a row is high."""
    aspect = 4 / 3
    y, x = places()
    ridge = 100 * np.exp(-(y**2) / 10 - x**2 / 500)
    (expected,) = reliefs([shaded(ridge.astype(np.float32))])
    slope_y, slope_x = (-one for one in np.gradient(ridge))
    on_gel_x, on_gel_y = slope_x / aspect**0.5, slope_y * aspect**0.5
    shade = np.stack([0 * y, SHADE_X * on_gel_x, SHADE_Y * on_gel_y], axis=-1).astype(np.float32)
    (found,), (taken_as_square,) = reliefs([shade], aspect), reliefs([shade])
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()
    assert np.abs(taken_as_square - expected).max() > 0.1 * np.abs(expected).max()


def test_shading_without_relief_does_not_integrate():
    """A field of pure curl is the shading of no relief."""
    slope_y, slope_x = np.gradient(100 * bump(3))
    curl = np.stack([-SHADE_Y * slope_x, -SHADE_X * slope_y, 0 * slope_x], axis=-1)
    (of_curl,) = reliefs([curl.astype(np.float32)])
    (of_bump,) = reliefs([shaded(100 * bump(3))])
    assert np.abs(of_curl).max() < 0.02 * np.abs(of_bump).max()


def test_an_untouched_gel_is_flat():
    (flat,) = reliefs([np.zeros((RELIEF_SIDE, RELIEF_SIDE, 3), np.float32)])
    assert not flat.any()


def test_under_mirrored_lights_the_relief_does_not_turn_inside_out():
    y, x = places()
    ridge = 100 * np.exp(-((x - y) ** 2) / 20 - (x + y) ** 2 / 250)
    (plain,) = reliefs([shaded(ridge)])
    seen = np.ascontiguousarray(shaded(ridge)[:, ::-1])
    (mirrored,) = reliefs([seen], are_lights_mirrored=True)
    assert np.abs(mirrored - plain[:, ::-1]).max() < 0.05 * np.abs(plain).max()


@pytest.mark.parametrize("radius_px", [1.5, 3])
def test_a_dent_that_came_out_as_a_bump_is_inside_out(radius_px):
    dents = reliefs([shaded(100 * bump(radius_px))] * 2)
    assert not is_inside_out(dents)
    assert is_inside_out(-dents)


def test_noise_and_a_flat_gel_are_not_inside_out():
    noise = np.random.default_rng(0).normal(size=(4, RELIEF_SIDE, RELIEF_SIDE)).astype(np.float32)
    assert not is_inside_out(noise)
    assert not is_inside_out(0 * noise)
