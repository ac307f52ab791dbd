"""Expected colours: measured on a GelSight Mini (flank right green, down blue, up red)."""

import numpy as np
import pytest

from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.optics import lit, turned_lights
from geotlm_lm.simulation.recording import recorded
from geotlm_lm.simulation.scene import Optics

AXIS = (np.arange(224) - 111.5).astype(np.float32)
GREY = np.full((3, 224, 224), 100, np.float32)


def ramp(towards_x, towards_y, slope=0.5):
    """Return an indentation that falls towards the given side of the image."""
    optics = Optics()
    x, y = AXIS[None, :] * optics.mm_per_px_x, AXIS[:, None] * optics.mm_per_px_y
    return (10 - slope * (towards_x * x + towards_y * y)).astype(np.float32)


@pytest.mark.parametrize(
    ("side", "expected"),
    [((1, 0), (-6, 24.5, -1.5)), ((0, 1), (-54, 3.5, 28)), ((0, -1), (54, -3.5, -28))],
)
def test_a_flank_takes_the_colour_of_the_light_it_faces(side, expected):
    optics = Optics(saturation=0, depth_gain=(0, 0, 0))
    change = lit(ramp(*side), GREY, optics)[:, 100:120, 100:120].mean(axis=(1, 2)) - 100
    assert change == pytest.approx(expected, abs=0.2)


def test_steep_flanks_saturate_as_the_formula_says():
    optics = Optics(saturation=1.5, depth_gain=(0, 0, 0))
    change = lit(ramp(1, 0, slope=1.0), GREY, optics)[1, 100:120, 100:120].mean() - 100
    assert change == pytest.approx(49 / np.sqrt(1 + 1.5**2), abs=0.2)


def test_a_light_turned_clockwise_from_above_comes_from_the_right():
    lights = turned_lights(Optics(light_turn_rad=(np.pi / 2, 0, 0)))
    assert lights[0] == pytest.approx((1.08, -0.12))
    assert np.array_equal(lights[1:], turned_lights(Optics())[1:])


@pytest.mark.parametrize("from_x", [1, -1])
def test_a_shadow_falls_behind_the_height_that_stands_towards_the_light(from_x):
    # A wall over the half of the image that the light comes from shades the low ground before it.
    wall = (AXIS * from_x > 0).astype(np.float32)
    height = np.tile(wall, (224, 1))
    lights = np.array([[from_x, 0.0]] * 3)
    plain, shaded = (
        lit(height, GREY, Optics(shadow=share, psf_mm=0, depth_gain=(0, 0, 0)), lights=lights)
        for share in (0.0, 0.3)
    )
    dark = (plain - shaded)[0, 112]
    reach_px = 0.6 / Optics().mm_per_px_x
    before = (AXIS * from_x < -1) & (AXIS * from_x > -reach_px)
    assert np.all(dark[before] > 10)
    assert not dark[AXIS * from_x > 2].any()
    assert not dark[AXIS * from_x < -reach_px - 1].any()


def test_a_flat_gel_shows_its_idle_frame():
    assert np.allclose(lit(np.zeros((224, 224), np.float32), GREY, Optics()), GREY)


def test_bright_light_saturates_instead_of_wrapping():
    image = recorded(GREY * 3, Optics(), generator_for(0, "noise"))
    assert image.min() == 255


def test_a_lossy_recording_keeps_its_colours():
    base = GREY * np.array([0.5, 1.0, 1.5], np.float32)[:, None, None]
    image = recorded(base, Optics(jpeg_quality=60), generator_for(0, "noise"))
    assert image.reshape(-1, 3).mean(axis=0) == pytest.approx((50, 100, 150), abs=1.5)
