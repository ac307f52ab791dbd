"""The pages of a TIFF by its directories, which are written here byte by byte."""

import io
import struct

import pytest

from geotlm_lm.core.image_size import page_sizes

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
    ("order", "is_big", "kind"), [("<", False, 4), (">", False, 4), ("<", True, 4), ("<", True, 16)]
)
def test_every_page_has_its_size_whatever_the_order_of_bytes(order, is_big, kind):
    assert page_sizes(io.BytesIO(tiff(SIZES, order, is_big=is_big, kind=kind)), 9) == SIZES


def test_short_numbers_stand_first_in_their_place_in_either_order():
    for order in "<>":
        stored = io.BytesIO(tiff([(37, 291)], order, kind=3))
        assert page_sizes(stored, 9) == [(37, 291)]


def test_no_more_pages_are_looked_at_than_asked_for():
    assert page_sizes(io.BytesIO(tiff(SIZES)), 2) == SIZES[:2]


def test_directories_in_a_circle_are_passed_once():
    assert page_sizes(io.BytesIO(tiff(SIZES, last=8)), 1000) == SIZES


def test_a_page_that_lies_outside_the_file_or_has_no_size_ends_the_list():
    whole = tiff(SIZES)
    assert page_sizes(io.BytesIO(whole[:-60]), 9) == [*SIZES[:1], None]
    for last in (10**6, 2**32 - 1):
        assert page_sizes(io.BytesIO(tiff(SIZES[:1], last=last)), 9) == [*SIZES[:1], None]
    vast = tiff(SIZES[:1], is_big=True, last=2**64 - 1)
    assert page_sizes(io.BytesIO(vast), 9) == [*SIZES[:1], None]
    assert page_sizes(io.BytesIO(tiff([(37, 291), (0, 5), (37, 291)])), 9) == [(37, 291), None]


@pytest.mark.parametrize("stored", [b"", b"II", b"\x89PNG\r\n\x1a\n", b"II*\0", b"GIF89a"])
def test_anything_else_has_none(stored):
    assert page_sizes(io.BytesIO(stored), 9) in ([], [None])
