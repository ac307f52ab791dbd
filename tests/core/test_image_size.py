"""An image's size is read from its header as the decoder reads it."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.image_size import declared_size

IMAGE = np.random.default_rng(0).integers(0, 255, (37, 291, 3)).astype(np.uint8)


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".jpg"])
@pytest.mark.parametrize("image", [IMAGE, IMAGE[..., 0]], ids=["colours", "grey"])
def test_the_declared_size_is_the_decoded_one(suffix, image):
    assert declared_size(cv2.imencode(suffix, image)[1].tobytes()) == (37, 291)


def test_a_progressive_jpeg_declares_it_too():
    code = cv2.imencode(".jpg", IMAGE, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
    assert declared_size(code) == (37, 291)


def test_a_bitmap_stored_from_the_top_has_its_rows():
    code = bytearray(cv2.imencode(".bmp", IMAGE)[1].tobytes())
    code[22:26] = (-37).to_bytes(4, "little", signed=True)
    assert declared_size(bytes(code)) == (37, 291)


@given(
    st.sampled_from((b"", b"\x89PNG\r\n\x1a\n", b"BM", b"\xff\xd8", b"\xff\xd8\xff")), st.binary()
)
@settings(derandomize=True, max_examples=300, deadline=None)
def test_anything_else_has_none_or_a_size(beginning, rest):
    size = declared_size(beginning + rest)
    assert size is None or (len(size) == 2 and min(size) >= 0)


def test_marks_in_a_row_are_passed_in_time_that_grows_with_the_file():
    assert declared_size(b"\xff\xd8" + b"\xff" * 200_000) is None
    assert declared_size(b"\xff\xd8" + b"\xff\xe0\x00\x00" * 50_000) is None
