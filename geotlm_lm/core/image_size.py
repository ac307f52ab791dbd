"""What an image file declares about its size, read before a decoder makes room for it."""

from __future__ import annotations

from io import BytesIO

from geotlm_lm.core.tiff_pages import BEGINNINGS as TIFFS
from geotlm_lm.core.tiff_pages import page_sizes

_PNG, _BMP, _JPEG, _RIFF = b"\x89PNG\r\n\x1a\n", b"BM", b"\xff\xd8", b"RIFF"
_FRAME_HEADERS = {0xC0, 0xC1, 0xC2, 0xC3, 0xC5, 0xC6, 0xC7, 0xC9, 0xCA, 0xCB, 0xCD, 0xCE, 0xCF}
"""Markers of a JPEG (ISO/IEC 10918-1, table B.1) after which its size stands."""


def declared_size(stored: bytes) -> tuple[int, int] | None:
    """Return (rows, columns) as the header of a PNG, BMP, JPEG, WebP or TIFF gives them.

    Args:
        stored: The file; its beginning is enough, of a TIFF the whole.

    Returns:
        None where it is no such file, or cut off before its size.
    """
    if stored.startswith(_PNG) and len(stored) >= 24:
        return int.from_bytes(stored[20:24]), int.from_bytes(stored[16:20])
    if stored.startswith(_BMP) and len(stored) >= 26:
        # An OS/2 header is 12 bytes long and holds 16-bit numbers; rows run upwards if negative.
        is_short = int.from_bytes(stored[14:18], "little") == 12
        sides = (stored[18:20], stored[20:22]) if is_short else (stored[18:22], stored[22:26])
        columns, rows = (int.from_bytes(side, "little", signed=not is_short) for side in sides)
        return abs(rows), abs(columns)
    if stored.startswith(_RIFF) and stored[8:12] == b"WEBP" and len(stored) >= 30:
        return _webp_size(stored)
    if stored.startswith(TIFFS):
        return next(iter(page_sizes(BytesIO(stored), most=1)), None)
    return _jpeg_size(stored) if stored.startswith(_JPEG) else None


def is_cut_off(stored: bytes) -> bool:
    """Tell whether a PNG declares a chunk that does not end within the file.

    A decoder makes room for the chunk before it looks for its bytes: four of them can ask for
    4 GB. False of any other file.
    """
    at, kind = len(_PNG), b""
    if not stored.startswith(_PNG):
        return False
    while kind != b"IEND" and at < len(stored):
        kind = stored[at + 4 : at + 8]
        at += 12 + int.from_bytes(stored[at : at + 4])  # length, name and checksum beside it
    return at > len(stored)


def _webp_size(stored: bytes) -> tuple[int, int] | None:
    """Return the size that a WebP's first chunk declares: lossy, lossless, or extended."""
    kind = stored[12:16]
    if kind == b"VP8 ":
        columns, rows = (int.from_bytes(stored[at : at + 2], "little") for at in (26, 28))
        return rows & 0x3FFF, columns & 0x3FFF
    if kind == b"VP8L":
        sides = int.from_bytes(stored[21:25], "little")
        return (sides >> 14 & 0x3FFF) + 1, (sides & 0x3FFF) + 1
    if kind == b"VP8X":
        columns, rows = (int.from_bytes(stored[at : at + 3], "little") for at in (24, 27))
        return rows + 1, columns + 1
    return None


def _jpeg_size(stored: bytes) -> tuple[int, int] | None:
    at = 2
    while at + 9 <= len(stored):
        if stored[at] != 0xFF:  # decoders look for the next marker past bytes that do not belong
            at += 1
            continue
        marker = stored[at + 1]
        if marker in _FRAME_HEADERS:
            return int.from_bytes(stored[at + 5 : at + 7]), int.from_bytes(stored[at + 7 : at + 9])
        has_length = 0xC0 <= marker <= 0xFE and not 0xD0 <= marker <= 0xD9
        at += 2 + int.from_bytes(stored[at + 2 : at + 4]) if has_length else 1
    return None
