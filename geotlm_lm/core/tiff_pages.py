"""The pages of a TIFF file and their sizes, by its directories alone, before anything is decoded.

TIFF 6.0, section 2, and BigTIFF, which has counts and offsets of 8 bytes in their place.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import SEEK_END
from itertools import islice
from typing import BinaryIO, Literal

BEGINNINGS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""Of a file with its numbers' lowest, or highest, byte first; the latter two of a BigTIFF."""

_COLUMNS, _ROWS = 256, 257
_BYTES_OF_TYPE = {3: 2, 4: 4, 16: 8}
"""Types of a whole number, SHORT, LONG and LONG8, and how long they are."""


def page_sizes(file: BinaryIO, most: int) -> list[tuple[int, int] | None]:
    """Return (rows, columns) of every page of a TIFF, in order; nothing of any other file.

    Args:
        file: Open for reading, at any place.
        most: Pages looked at; a chain of directories may be endless.

    Returns:
        None last where a page declares no size or lies outside the file: what follows is not known.
    """
    return list(islice(_sizes(file), most))


def _sizes(file: BinaryIO) -> Iterator[tuple[int, int] | None]:
    end = file.seek(0, SEEK_END)
    file.seek(0)
    beginning = file.read(4)
    if beginning not in BEGINNINGS:
        return
    order: Literal["little", "big"] = "little" if beginning.startswith(b"II") else "big"
    is_big = b"+" in beginning
    wide, counted, entry_length = (8, 8, 20) if is_big else (4, 2, 12)
    file.seek(8 if is_big else 4)
    at, seen = int.from_bytes(file.read(wide), order), set()
    while at and at not in seen:
        seen.add(at)
        if at >= end:  # further than any file may be sought in, perhaps
            yield None
            return
        file.seek(at)
        count = int.from_bytes(file.read(counted), order)
        if count > _MOST_ENTRIES:
            count = 0
        entries = file.read(count * entry_length)
        told = {}
        for start in range(0, len(entries) - entry_length + 1, entry_length):
            tag, kind = (int.from_bytes(entries[i : i + 2], order) for i in (start, start + 2))
            value = start + entry_length - wide
            length = _BYTES_OF_TYPE.get(kind, 0)
            told[tag] = int.from_bytes(entries[value : value + min(length, wide)], order)
        rows, columns = told.get(_ROWS, 0), told.get(_COLUMNS, 0)
        if not rows or not columns:
            yield None
            return
        yield rows, columns
        at = int.from_bytes(file.read(wide), order)


_MOST_ENTRIES = 4096
"""Of a directory; those of cameras have some dozens."""
