"""The drawing of the viewpoint turns with the frame: expected from the frame's own rule."""

import numpy as np
import pytest

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.views.viewpoint import _FACE_AT, draw_viewpoint


def arrow_head_side(image):
    """Return on which side of the face the red arrow is heavier: its head is there."""
    red = (image[..., 0].astype(int) - image[..., 1] > 80)[:, 240:]
    columns = np.nonzero(red)[1] + 240
    return np.sign(np.mean(columns) - _FACE_AT[0])


@pytest.mark.parametrize(
    ("frame", "side"),
    [
        (FrameSpec(), 1),
        (FrameSpec(image_mirrored=True), -1),
        (FrameSpec(viewpoint="object"), -1),
        (FrameSpec(actor="sensor"), -1),
        (FrameSpec(viewpoint="object", actor="sensor"), 1),
    ],
)
def test_what_the_image_shows_as_clockwise_is_drawn_as_the_frame_tells_it(frame, side):
    assert arrow_head_side(draw_viewpoint(frame)) == side


def test_the_eye_moves_to_the_objects_side():
    sensor, other = draw_viewpoint(FrameSpec()), draw_viewpoint(FrameSpec(viewpoint="object"))
    assert (sensor[60:76, 40:70] < 100).any()
    assert not (other[60:76, 40:70] < 100).any()
    assert (other[60:76, 198:226] < 100).any()
