"""What an image file declares about its size and pages, read before a decoder makes room for it.

Pillow reads the headers. Its readers are called directly, without the check of sizes that
`Image.open` adds: whoever asks here has a stricter limit and names the size.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from io import SEEK_END, BytesIO
from itertools import islice
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

_PNG, _TIFF = b"\x89PNG\r\n\x1a\n", (b"II", b"MM")
_COLUMNS_TAG, _ROWS_TAG = 256, 257


def declared_size(stored: bytes) -> tuple[int, int] | None:
    """Return (rows, columns) as the header of a PNG, BMP, JPEG, WebP or TIFF gives them.

    Args:
        stored: The whole file.

    Returns:
        None where it is no such file, or cut off before its size.
    """
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

    By the directories alone: Pillow opens no page of a kind that it cannot decode, OpenCV may.

    Args:
        file: Open for reading, at any place.
        most: Pages looked at; a chain of directories may be endless.

    Returns:
        None last where a page declares no size or lies outside the file: what follows is not known.
    """
    return list(islice(_page_sizes(file), most))


def _page_sizes(file: BinaryIO) -> Iterator[tuple[int, int] | None]:
    from PIL.TiffImagePlugin import PREFIXES, ImageFileDirectory_v2

    # Of a damaged directory Pillow warns on stderr; here it is told by None.
    warnings.filterwarnings("ignore", module=r"PIL\.TiffImagePlugin")
    end = file.seek(0, SEEK_END)
    file.seek(0)
    header = file.read(16)
    if not header.startswith(tuple(PREFIXES)):
        return
    seen = {0}
    try:
        is_big = header[2:4] in (b"+\0", b"\0+")
        directory = ImageFileDirectory_v2(header if is_big else header[:8])
        while directory.next not in seen:
            seen.add(at := directory.next)
            directory.next = 0  # stays where the directory is damaged
            if at < end:
                file.seek(at)
                directory.load(file)
            size = int(directory.get(_ROWS_TAG, 0)), int(directory.get(_COLUMNS_TAG, 0))
            yield size if all(size) and at < end else None
            if not all(size) or at >= end:
                return
    except Exception:  # Pillow raises whatever the damage leads to
        yield None


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
