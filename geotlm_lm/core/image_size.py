"""What an image file declares about its size and pages, read before a decoder makes room for it.

Pillow reads the headers of all but TIFF. Its readers are called directly, without the check of
sizes that `Image.open` adds: the callers have a stricter limit and name the size.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from io import SEEK_END, BytesIO
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

_PNG, _TIFF = b"\x89PNG\r\n\x1a\n", (b"II", b"MM")
_COLUMNS_TAG, _ROWS_TAG = 256, 257


def declared_size(stored: bytes) -> tuple[int, int] | None:
    """Return (rows, columns) by the header of a PNG, BMP, JPEG, WebP or TIFF; None without one."""
    if stored.startswith(_TIFF):
        return next(iter(page_sizes(BytesIO(stored), most=1)), None)
    image = _opened(stored)
    if image is not None:
        return image.size[::-1]
    return _size_of_damaged_png(stored) if stored.startswith(_PNG) else None


def is_cut_off(stored: bytes) -> bool:
    """Tell whether a PNG ends early or has a damaged chunk. False of any other file.

    A decoder makes room for a chunk before it looks for its bytes: four of them can ask for 4 GB.
    """
    if not stored.startswith(_PNG):
        return False
    try:
        _opened(stored).verify()  # type: ignore[union-attr]  # None is cut off too
    except Exception:  # Pillow raises whatever the damage leads to
        return True
    return False


def page_sizes(file: BinaryIO, most: int) -> list[tuple[int, int] | None]:
    """Return (rows, columns) of every page of a TIFF, in order; nothing of any other file.

    By the directories alone (TIFF 6.0 section 2, BigTIFF): a library opens no page of a kind that
    it cannot decode, and which damage it passes over changes with its version.

    The last is None where a page declares no size or points outside the file: what follows is
    unknown. No more than `most` are looked at, as a chain of directories may be endless.
    """
    end = file.seek(0, SEEK_END)
    file.seek(0)
    head = file.read(16)
    form = _tiff_form(head)
    if form is None:
        return []
    sizes: list[tuple[int, int] | None] = []
    seen: set[int] = set()
    is_there = len(head) >= form.first_at + struct.calcsize(form.offset)
    at = struct.unpack_from(form.offset, head, form.first_at)[0] if is_there else end
    while at and at not in seen and len(sizes) < most:
        seen.add(at)
        size, at = _directory(file, at, end, form)
        sizes.append(size)
        if size is None:
            break
    return sizes


@dataclass(frozen=True)
class _TiffForm:
    """Formats of a count of entries, of an entry (tag, type, count), and of an offset."""

    count: str
    entry: str
    offset: str
    first_at: int


def _tiff_form(head: bytes) -> _TiffForm | None:
    order = {b"II": "<", b"MM": ">"}.get(head[:2])
    if order is None or len(head) < 4:
        return None
    forms = {
        42: _TiffForm(f"{order}H", f"{order}HHI", f"{order}I", 4),
        43: _TiffForm(f"{order}Q", f"{order}HHQ", f"{order}Q", 8),
    }
    return forms.get(struct.unpack_from(f"{order}H", head, 2)[0])


_VALUE_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8}
_VALUE_BYTES |= {13: 4, 16: 8, 17: 8, 18: 8}
"""Bytes of a value by its type."""

_INTEGERS = {3: "H", 4: "I", 16: "Q"}
"""Format of a value by its type, of those in which a side may be given."""


def _directory(
    file: BinaryIO, at: int, end: int, form: _TiffForm
) -> tuple[tuple[int, int] | None, int]:
    """Return the size of a page, None where its directory is damaged, and where the next one is."""
    offset_bytes = struct.calcsize(form.offset)
    entry_bytes = struct.calcsize(form.entry) + offset_bytes
    file.seek(min(at, end))
    count_bytes = file.read(struct.calcsize(form.count))
    if len(count_bytes) < struct.calcsize(form.count):
        return None, 0
    [count] = struct.unpack(form.count, count_bytes)
    if count * entry_bytes > end:
        return None, 0
    entries = file.read(count * entry_bytes + offset_bytes)
    if len(entries) < count * entry_bytes + offset_bytes:
        return None, 0
    sides = {}
    for start in range(0, count * entry_bytes, entry_bytes):
        tag, kind, values = struct.unpack_from(form.entry, entries, start)
        length = values * _VALUE_BYTES.get(kind, 1)
        where = start + entry_bytes - offset_bytes
        if length > offset_bytes:
            if struct.unpack_from(form.offset, entries, where)[0] + length > end:
                return None, 0
        elif tag in (_ROWS_TAG, _COLUMNS_TAG) and kind in _INTEGERS:
            [sides[tag]] = struct.unpack_from(form.count[0] + _INTEGERS[kind], entries, where)
    rows, columns = sides.get(_ROWS_TAG, 0), sides.get(_COLUMNS_TAG, 0)
    [after] = struct.unpack_from(form.offset, entries, count * entry_bytes)
    return ((rows, columns), after) if rows and columns else (None, 0)


def _size_of_damaged_png(stored: bytes) -> tuple[int, int] | None:
    """Return what the first chunk declares though its checksum, or another chunk, is wrong."""
    from PIL.PngImagePlugin import PngStream

    stream = PngStream(BytesIO(stored[len(_PNG) :]))
    try:
        stream.call(*stream.read())
    except Exception:  # Pillow raises whatever the damage leads to
        return None
    return stream.im_size[::-1]


def _opened(stored: bytes) -> ImageFile | None:
    """Return an image whose header was read; None where it is none of ours or damaged."""
    from PIL import BmpImagePlugin, JpegImagePlugin, PngImagePlugin, WebPImagePlugin

    readers = {
        b"\x89PNG": PngImagePlugin.PngImageFile,
        b"BM": BmpImagePlugin.BmpImageFile,
        b"\xff\xd8": JpegImagePlugin.JpegImageFile,
        b"RIFF": WebPImagePlugin.WebPImageFile,
    }
    reader = next((one for start, one in readers.items() if stored.startswith(start)), None)
    try:
        return None if reader is None else reader(BytesIO(stored))
    except Exception:  # Pillow raises whatever the damage leads to
        return None
