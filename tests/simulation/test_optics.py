"""Expected colours: measured on a GelSight Mini (flank right green, down blue, up red)."""

import numpy as np
import pytest

from geotlm_lm.core.seeding import generator_for
from geotlm_lm.simulation.optics import lit, recorded
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


def test_a_flat_gel_shows_its_idle_frame():
    assert np.allclose(lit(np.zeros((224, 224), np.float32), GREY, Optics()), GREY)


def test_the_recording_has_the_noise_asked_for():
    optics = Optics(noise_grey=(2.0, 1.0, 3.0))
    image = recorded(GREY, optics, generator_for(0, "noise"))
    assert image.reshape(-1, 3).std(axis=0) == pytest.approx((2.0, 1.0, 3.0), rel=0.06)
    assert image.reshape(-1, 3).mean(axis=0) == pytest.approx((100, 100, 100), abs=0.05)


def test_bright_light_saturates_instead_of_wrapping():
    image = recorded(GREY * 3, Optics(), generator_for(0, "noise"))
    assert image.min() == 255


def test_a_lossy_recording_keeps_its_colours():
    base = GREY * np.array([0.5, 1.0, 1.5], np.float32)[:, None, None]
    image = recorded(base, Optics(jpeg_quality=60), generator_for(0, "noise"))
    assert image.reshape(-1, 3).mean(axis=0) == pytest.approx((50, 100, 150), abs=1.5)
