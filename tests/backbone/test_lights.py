"""Expected values: a known relief shaded by lights that stand elsewhere than the usual ones."""

import numpy as np
import pytest

from geotlm_lm.backbone.relief import (
    RELIEF_SIDE,
    SHADE_GREY,
    SHADE_X,
    SHADE_Y,
    Lights,
    as_of_one_light,
    lights_of,
    turned_by_a_quarter,
)

SIDE = RELIEF_SIDE


def relief():
    """A twisted bump: its mirror image is another one."""
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    bar = np.exp(-((x - y) ** 2) / 25 - (x + y) ** 2 / 375)
    return 100 * (bar + 0.7 * np.exp(-((x - 10) ** 2 + (y - 2.5) ** 2) / 15)).astype(np.float32)


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
        assert lights_of([noisy(np.zeros((SIDE, SIDE, 3)), seed)] * 4) == Lights()
    assert lights_of([np.zeros((SIDE, SIDE, 3), np.float32)]) == Lights()


@pytest.mark.parametrize("colours", [(1, 1, 1), (0, 1, 0)])
def test_a_grey_picture_and_one_of_one_colour_tell_no_lights_apart(colours):
    grey = shaded(relief()) @ np.array([0.299, 0.587, 0.114])
    seen = (grey[..., None] * colours).astype(np.float32)
    assert lights_of([seen] * 2, 4 / 3) == Lights(are_one=True)
    assert not lights_of([shaded(relief())], 4 / 3).are_one


def test_a_grey_picture_gets_the_colours_of_slopes_towards_one_light():
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
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
