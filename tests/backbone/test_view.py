"""Expected values: slices of the image, and OpenCV's affine warp of the same square."""

import cv2
import numpy as np
import pytest

from geotlm_lm.backbone.view import View, contact_view


def test_the_whole_view_cuts_nothing_and_a_half_view_magnifies_twice():
    image = np.arange(224 * 224, dtype=np.float32).reshape(224, 224)
    assert np.array_equal(View().cut(image), image)
    quarter = View(56, 56, 112).cut(image)
    # The image is a ramp; the view's second pixel lies a quarter past the image's first.
    assert np.array_equal(quarter[1:-1:2, 1:-1:2], image[:111, :111] + 0.25 * (224 + 1))


def test_a_grid_and_an_image_are_cut_alike():
    rows, columns = np.mgrid[:224, :224].astype(np.float32)
    view = View(90, 130, 128)
    image = view.cut(columns)
    grid = view.cut(cv2.resize(columns, (14, 14), interpolation=cv2.INTER_AREA))
    means = cv2.resize(image, (14, 14), interpolation=cv2.INTER_AREA)
    assert grid == pytest.approx(means, abs=0.5)


@pytest.mark.parametrize("corner", [(40, 60), (-30, 100), (150, -20)])
@pytest.mark.parametrize("side", [97, 128, 224])
def test_whole_pixels_are_cut_as_an_affine_warp_cuts_them(corner, side):
    rng = np.random.default_rng(0)
    image = cv2.GaussianBlur(rng.normal(size=(224, 224, 3)).astype(np.float32), (0, 0), 3)
    scale = side / 224
    starts = [start + 0.5 * scale - 0.5 for start in corner]
    matrix = np.float32([[scale, 0, starts[0]], [0, scale, starts[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpAffine(image, matrix, (224, 224), flags=flags)
    cut = View(corner[0] + side / 2, corner[1] + side / 2, side).cut(image)
    # At the rim the warp mixes in what lies outside of the square.
    assert np.abs(cut - warped)[3:-3, 3:-3].max() < 0.03 * image.std()


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
