"""How pictures of other shapes than a camera's fill our square."""

import pytest

from geotlm_lm.core.geometry import IMAGE_SIDE, filled_size, pixel_aspect


@pytest.mark.parametrize(
    ("size", "filled"),
    [
        *((size, (224, 224)) for size in ((240, 320), (224, 224), (1944, 2592), (233, 320))),
        ((320, 240), (224, 126)),
        ((240, 240), (224, 168)),
        ((1080, 1920), (168, 224)),
        ((8, 4000), (2, 224)),
        ((4000, 8), (224, 2)),
    ],
)
def test_a_cameras_picture_fills_the_square_and_idle_gel_what_others_leave(size, filled):
    assert filled_size(*size) == filled
    assert all((IMAGE_SIDE - side) % 2 == 0 for side in filled)


@pytest.mark.parametrize("size", [(320, 240), (240, 240), (1080, 1920), (224, 224), (480, 640)])
def test_pixels_of_the_square_are_of_one_shape_whatever_filled_it(size):
    assert pixel_aspect(*size) == pytest.approx(4 / 3, rel=0.01)
