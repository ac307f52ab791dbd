"""Expected values: slices of the image, and OpenCV's affine warp of the same square."""

import numpy as np
import pytest

from geotlm_lm.backbone.view import View, contact_view


def test_the_whole_view_cuts_nothing_and_a_half_view_magnifies_twice():
    image = np.arange(224 * 224, dtype=np.float32).reshape(224, 224)
    assert np.array_equal(View().cut(image), image)
    quarter = View(56, 56, 112).cut(image)
    # The image is a ramp; the view's second pixel lies a quarter past the image's first.
    assert np.array_equal(quarter[1:-1:2, 1:-1:2], image[:111, :111] + 0.25 * (224 + 1))


@pytest.mark.parametrize("corner", [(-130, 40), (40, -130), (240, 40), (40, 240)])
def test_nothing_is_seen_beside_the_image(corner):
    cut = View(corner[0] + 50, corner[1] + 50, 100).cut(np.ones((224, 224, 3), np.float32))
    assert cut.shape == (224, 224, 3)
    assert not cut.any()


def test_a_view_lies_on_whole_pixels():
    energy = np.zeros((28, 28), np.float32)
    energy[5:12, 9:17] = np.random.default_rng(0).uniform(50, 900, (7, 8))
    view = contact_view([energy])
    corner = (view.centre_x_px - view.side_px / 2, view.centre_y_px - view.side_px / 2)
    assert all(float(length).is_integer() for length in (*corner, view.side_px))
    assert (view.centre_x_px, view.centre_y_px) == pytest.approx((104, 68), abs=8)


@pytest.mark.parametrize("noise", [0.0, 5.0, 40.0])
def test_noise_that_is_everywhere_moves_no_view(noise):
    energy = np.zeros((28, 28), np.float32)
    energy[5:9, 18:22] = 900
    seen = contact_view([energy + np.float32(noise)])
    # Of four cells of eight pixels: the middle, and less than the smallest view.
    assert (seen.centre_x_px, seen.centre_y_px, seen.side_px) == (160, 56, 96)
