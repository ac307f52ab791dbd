"""Expected values: a known relief shaded by the usual lights, and by lights elsewhere."""

import numpy as np
import pytest

from geotlm_lm.backbone.relief import (
    RELIEF_SIDE,
    SHADE_GREY,
    SHADE_X,
    SHADE_Y,
    Lights,
    as_of_one_light,
    is_inside_out,
    lights_of,
    reliefs,
    turned_by_a_quarter,
)


def places():
    return np.mgrid[:RELIEF_SIDE, :RELIEF_SIDE] - (RELIEF_SIDE - 1) / 2


def relief():
    """A twisted bump: its mirror image is another one."""
    y, x = places()
    bar = np.exp(-((x - y) ** 2) / 25 - (x + y) ** 2 / 375)
    return 100 * (bar + 0.7 * np.exp(-((x - 10) ** 2 + (y - 2.5) ** 2) / 15)).astype(np.float32)


def bump(radius_px):
    rows, columns = places()
    return np.exp(-(rows**2 + columns**2) / (2 * radius_px**2)).astype(np.float32)


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
    slope_y, slope_x = np.gradient(100 * bump(3))
    curl = np.stack([-SHADE_Y * slope_x, -SHADE_X * slope_y, 0 * slope_x], axis=-1)
    (of_curl,) = reliefs([curl.astype(np.float32)])
    (of_bump,) = reliefs([shaded(100 * bump(3))])
    assert np.abs(of_curl).max() < 0.02 * np.abs(of_bump).max()


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


def shaded(depth, aspect=1.0):
    """Shade a relief as the usual lights do, with slopes s = -grad d on the gel."""
    slope_y, slope_x = (-one for one in np.gradient(depth))
    shade_x, shade_y = SHADE_X * slope_x / aspect**0.5, SHADE_Y * slope_y * aspect**0.5
    return np.stack([-0.5 * shade_y, shade_x, 0.5 * shade_y], axis=-1).astype(np.float32)


def noisy(image, seed=0):
    noise = np.random.default_rng(seed).normal(size=image.shape) * 0.3
    return np.ascontiguousarray(image + noise, np.float32)


@pytest.mark.parametrize("quarters", range(4))
@pytest.mark.parametrize("is_mirrored", [False, True])
def test_the_curl_of_the_slopes_tells_where_the_lights_stand(quarters, is_mirrored):
    seen = shaded(relief())
    seen = seen[:, ::-1] if is_mirrored else seen
    seen = noisy(np.rot90(seen, quarters))
    assert lights_of([seen] * 2) == Lights(quarters % 2 == 1, is_mirrored)


@pytest.mark.parametrize("aspect", [4 / 3, 3 / 4])
def test_a_squashed_picture_does_not_look_like_turned_lights(aspect):
    usual = shaded(relief(), aspect)
    assert lights_of([noisy(usual)], aspect) == Lights()
    assert lights_of([noisy(turned_by_a_quarter(usual))], aspect).are_turned


def test_neither_noise_nor_an_idle_gel_turns_the_lights():
    for seed in range(20):
        assert lights_of([noisy(np.zeros((RELIEF_SIDE, RELIEF_SIDE, 3)), seed)] * 4) == Lights()
    assert lights_of([np.zeros((RELIEF_SIDE, RELIEF_SIDE, 3), np.float32)]) == Lights()


@pytest.mark.parametrize("colours", [(1, 1, 1), (0, 1, 0)])
def test_a_grey_picture_and_one_of_one_colour_tell_no_lights_apart(colours):
    grey = shaded(relief()) @ np.array([0.299, 0.587, 0.114])
    seen = (grey[..., None] * colours).astype(np.float32)
    assert lights_of([seen] * 2, 4 / 3) == Lights(are_one=True)
    assert not lights_of([shaded(relief())], 4 / 3).are_one


def test_a_grey_picture_gets_the_colours_of_slopes_towards_one_light():
    y, x = places()
    ridge = 100 * np.exp(-((x - y) ** 2) / 50)  # falls towards the upper right and lower left
    slope_y, slope_x = (-one for one in np.gradient(ridge))
    grey = SHADE_GREY * (slope_x - slope_y) / 2**0.5
    seen = np.repeat(grey[..., None], 3, axis=-1).astype(np.float32)
    inside = slice(1, -1)  # where slopes are central differences
    found, expected = (one[inside, inside] for one in (as_of_one_light(seen), shaded(ridge)))
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()


def test_a_picture_turned_back_is_that_of_the_turned_relief_under_the_usual_lights():
    for quarters in (1, 3):
        seen = np.ascontiguousarray(np.rot90(shaded(relief()), quarters))
        found = turned_by_a_quarter(seen)
        expected = shaded(np.ascontiguousarray(np.rot90(relief(), quarters)))
        sign = np.sign((found * expected).sum())
        assert sign == (1 if quarters == 1 else -1)
        assert np.abs(sign * found - expected).max() < 1e-3 * np.abs(expected).max()
