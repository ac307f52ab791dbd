"""What was said of a clip's pixels holds while its frames keep their size, and for no other."""

import numpy as np
import pytest

from app import clip_side
from app.clip_loading import perceive
from geotlm_lm.core.clip import Clip
from tests.app.fakes import FakeAnswerer

LOOKED_AT = ("raw", 4, [])


def opened(rows, columns):
    frames = np.full((4, rows, columns, 3), 90, np.uint8)
    return perceive(FakeAnswerer(), Clip(frames, background=frames[0]))


@pytest.mark.parametrize(
    ("before", "kept"), [(None, 0.06), ((48, 64), 0.06), ((64, 48), 0), ((96, 128), 0)]
)
def test_the_size_of_a_pixel_stays_for_frames_of_the_same_size(before, kept):
    closed = None if before is None else opened(*before)
    *_, size = clip_side._opened(opened(48, 64), "b.npy", *LOOKED_AT, 0.06, closed)
    assert size == kept


def test_the_size_of_a_pixel_goes_with_the_clip_it_was_said_of():
    *_, before_any_clip = clip_side._closed(None, *LOOKED_AT, 0.06, None)
    *_, with_the_clip = clip_side._closed(None, *LOOKED_AT, 0.06, opened(48, 64))
    assert (before_any_clip, with_the_clip) == (0.06, 0)
