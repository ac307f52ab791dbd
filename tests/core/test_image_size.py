"""An image's size, and those of a TIFF's pages, are read from headers as decoders read them."""

import io
import struct
import warnings

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.image_size import declared_size, is_cut_off, page_sizes

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


@given(st.sampled_from(BEGINNINGS), st.binary())
@settings(derandomize=True, max_examples=300, deadline=None)
def test_any_bytes_have_a_size_or_none_and_are_judged(beginning, rest):
    size = declared_size(beginning + rest)
    assert size is None or (len(size) == 2 and min(size) >= 0)
    is_cut_off(beginning + rest)


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


SIZES = [(37, 291), (5, 70_000), (1, 2)]


def tiff(sizes, order="<", *, is_big=False, kind=4, last=0):
    """Return a TIFF of empty pages whose last directory points to `last`."""
    head = (b"II" if order == "<" else b"MM") + struct.pack(f"{order}H", 43 if is_big else 42)
    if is_big:
        head += struct.pack(f"{order}HHQ", 8, 0, 16)
    else:
        head += struct.pack(f"{order}I", 8)
    number = {3: "H", 4: "I", 16: "Q"}[kind]
    form, count, offset, room = ("HHQ", "Q", "Q", 8) if is_big else ("HHI", "H", "I", 4)
    stored = head
    for place, (rows, columns) in enumerate(sizes):
        entries = b""
        for tag, side in ((254, 0), (256, columns), (257, rows)):
            value = struct.pack(f"{order}{number}", side).ljust(room, b"\0")
            entries += struct.pack(f"{order}{form}", tag, kind, 1) + value
        directory = struct.pack(f"{order}{count}", 3) + entries
        after = len(stored) + len(directory) + room
        stored += directory
        stored += struct.pack(f"{order}{offset}", last if place == len(sizes) - 1 else after)
    return stored


@pytest.mark.parametrize(
    ("order", "is_big", "kind"),
    [("<", False, 4), (">", False, 4), ("<", True, 4), ("<", True, 16)],
)
def test_every_page_has_its_size_whatever_the_order_of_bytes(order, is_big, kind):
    assert page_sizes(io.BytesIO(tiff(SIZES, order, is_big=is_big, kind=kind)), 9) == SIZES
    # Short numbers stand first in their place in either order.
    assert page_sizes(io.BytesIO(tiff([(37, 291)], order, kind=3)), 9) == [(37, 291)]


def test_no_more_pages_are_looked_at_than_asked_for_and_a_circle_is_passed_once():
    assert page_sizes(io.BytesIO(tiff(SIZES)), 2) == SIZES[:2]
    assert page_sizes(io.BytesIO(tiff(SIZES, last=8)), 1000) == SIZES


def test_a_page_that_lies_outside_the_file_or_has_no_size_ends_the_list():
    whole = tiff(SIZES)
    assert page_sizes(io.BytesIO(whole[:-60]), 9) == [*SIZES[:1], None]
    for last in (10**6, 2**32 - 1):
        assert page_sizes(io.BytesIO(tiff(SIZES[:1], last=last)), 9) == [*SIZES[:1], None]
    vast = tiff(SIZES[:1], is_big=True, last=2**64 - 1)
    assert page_sizes(io.BytesIO(vast), 9) == [*SIZES[:1], None]
    assert page_sizes(io.BytesIO(tiff([(37, 291), (0, 5), (37, 291)])), 9) == [(37, 291), None]
