"""An image's size is read from its header as the decoder reads it."""

import warnings

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.image_size import declared_size, is_cut_off

BEGINNINGS = (
    b"",
    b"\x89PNG\r\n\x1a\n",
    b"BM",
    b"\xff\xd8",
    b"\xff\xd8\xff",
    b"RIFF\0\0\0\0WEBPVP8X",
    b"RIFF\0\0\0\0WEBPVP8L",
    b"II*\0\x08\0\0\0",
    b"MM\0*\0\0\0\x08",
)
IMAGE = np.random.default_rng(0).integers(0, 255, (37, 291, 3)).astype(np.uint8)


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".jpg", ".webp", ".tif"])
@pytest.mark.parametrize("image", [IMAGE, IMAGE[..., 0]], ids=["colours", "grey"])
def test_the_declared_size_is_the_decoded_one(suffix, image):
    assert declared_size(cv2.imencode(suffix, image)[1].tobytes()) == (37, 291)


def test_a_progressive_jpeg_declares_it_too():
    code = cv2.imencode(".jpg", IMAGE, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
    assert declared_size(code) == (37, 291)


def test_every_sort_of_webp_declares_it():
    lossy, lossless = (
        cv2.imencode(".webp", IMAGE, [cv2.IMWRITE_WEBP_QUALITY, quality])[1].tobytes()
        for quality in (60, 101)
    )
    assert (lossy[12:16], lossless[12:16]) == (b"VP8 ", b"VP8L")
    assert declared_size(lossy) == declared_size(lossless) == (37, 291)
    # An extended one stores both sides less one in three bytes each, after four of flags.
    sides = (291 - 1).to_bytes(3, "little") + (37 - 1).to_bytes(3, "little")
    chunks = b"WEBPVP8X" + (10).to_bytes(4, "little") + bytes(4) + sides + lossy[12:]
    assert declared_size(b"RIFF" + len(chunks).to_bytes(4, "little") + chunks) == (37, 291)
    assert declared_size(lossy[:12] + b"EXIF" + lossy[16:]) is None


def test_a_bitmap_stored_from_the_top_has_its_rows():
    code = bytearray(cv2.imencode(".bmp", IMAGE)[1].tobytes())
    code[22:26] = (-37).to_bytes(4, "little", signed=True)
    assert declared_size(bytes(code)) == (37, 291)


@given(st.sampled_from(BEGINNINGS), st.binary())
@settings(derandomize=True, max_examples=300, deadline=None)
def test_anything_else_has_none_or_a_size(beginning, rest):
    size = declared_size(beginning + rest)
    assert size is None or (len(size) == 2 and min(size) >= 0)


def test_marks_in_a_row_are_passed_in_time_that_grows_with_the_file():
    assert declared_size(b"\xff\xd8" + b"\xff" * 200_000) is None
    assert declared_size(b"\xff\xd8" + b"\xff\xe0\x00\x00" * 50_000) is None


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".jpg"])
def test_a_whole_file_is_not_cut_off_nor_is_one_with_more_behind_it(suffix):
    code = cv2.imencode(suffix, IMAGE)[1].tobytes()
    assert not is_cut_off(code)
    assert not is_cut_off(code + b"more")


def test_a_png_that_ends_early_is_cut_off_wherever_that_is():
    code = cv2.imencode(".png", IMAGE[:3, :3])[1].tobytes()
    assert all(is_cut_off(code[:end]) for end in range(8, len(code) - 4))  # the end's own checksum


def test_a_png_with_a_damaged_chunk_is_cut_off():
    code = bytearray(cv2.imencode(".png", IMAGE)[1].tobytes())
    code[len(code) // 2] ^= 1
    assert is_cut_off(bytes(code))


@pytest.mark.parametrize("side", [20_000, 60_000])
def test_a_size_that_pillow_takes_for_a_bomb_is_told_and_neither_refused_nor_warned_of(side):
    code = bytearray(cv2.imencode(".jpg", IMAGE)[1].tobytes())
    at = code.find(b"\xff\xc0") + 5
    code[at : at + 4] = 2 * side.to_bytes(2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert declared_size(bytes(code)) == (side, side)


def test_a_chunk_larger_than_the_file_is_found_before_room_is_made_for_it():
    code = bytearray(cv2.imencode(".png", IMAGE)[1].tobytes())
    assert code[37:41] == b"IDAT"
    code[33] = 0xFF
    assert is_cut_off(bytes(code))


@given(st.binary())
@settings(derandomize=True, max_examples=200, deadline=None)
def test_what_is_no_png_is_not_cut_off_and_any_png_is_judged(rest):
    is_cut_off(b"\x89PNG\r\n\x1a\n" + rest)
    assert not is_cut_off(b"x" + rest)
