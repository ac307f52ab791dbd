"""Which recordings a program may name: what it sent to this server, and nothing else."""

from __future__ import annotations

import base64
import binascii
import hashlib
import os
from pathlib import Path
from typing import Any, Literal, TypedDict
from urllib.parse import unquote, urlsplit

from geotlm_lm import GeoTLMError

INLINE_BYTES = 64 * 2**20
"""Of a recording inside a message; it is held in memory several times on its way."""

FILE_ROUTE = "/gradio_api/file="
"""What the toolkit puts before the path of an upload."""

BEGINNINGS = {
    ".npy": (0, b"\x93NUMPY"),
    ".npz": (0, b"PK\x03\x04"),
    ".avi": (8, b"AVI "),
    ".mp4": (4, b"ftyp"),
    ".mkv": (0, b"\x1a\x45\xdf\xa3"),
    ".tif": (0, b"II*\0"),
    ".tiff": (0, b"MM\0*"),  # the same with its numbers the other way round
}
"""Where a file's kind is written in it, and how: a recording inside a message has no name."""


class UploadMeta(TypedDict):
    """Marks an upload for the toolkit."""

    _type: Literal["gradio.FileData"]


class Upload(TypedDict):
    """A file as the Python client sends it."""

    path: str
    meta: UploadMeta


class Uploads:
    """Finds what was sent.

    Args:
        folder: That uploads are put in; a recording from elsewhere is refused.
    """

    def __init__(self, folder: str | Path) -> None:
        self._folder = Path(folder).resolve()

    def path_of(self, clip: Any) -> str:
        """Return the path of a recording that was sent; nothing else on this machine is opened.

        Args:
            clip: What the Python client sends, the path or the address of an upload, or a data URI
                in base64.

        Raises:
            GeoTLMError: If it is none of these, or too long.
        """
        given = clip.get("path") if isinstance(clip, dict) else clip
        if isinstance(given, str) and given.startswith("data:"):
            return self._unpacked(given)
        if isinstance(given, str) and FILE_ROUTE in given:
            given = unquote(urlsplit(given).path.split(FILE_ROUTE, 1)[-1])
        try:
            inside = isinstance(given, str) and Path(given).resolve().is_relative_to(self._folder)
        except (OSError, ValueError):  # no path at all: too long, or with a null byte
            inside = False
        if not inside:
            raise GeoTLMError(
                "The clip is no upload; send the file itself, in Python by "
                "handle_file('clip.npz'), or as a data URI in base64."
            )
        return given

    def _unpacked(self, uri: str) -> str:
        """Write the recording in a data URI to a file and return its path."""
        form, _, content = uri.partition(",")
        if not form.endswith(";base64"):
            raise GeoTLMError(
                "The clip's data URI is not in base64; send 'data:;base64,' and the file in base64."
            )
        if len(content) > INLINE_BYTES * 4 // 3 + 4:
            raise GeoTLMError(
                f"The clip is {len(content) * 3 // 4 / 2**20:.0f} MiB long, expected at most "
                f"{INLINE_BYTES // 2**20} inside a message; upload it and send its address."
            )
        try:
            stored = base64.b64decode(content, validate=True)
        except (binascii.Error, ValueError) as error:
            raise GeoTLMError(
                "The clip's data URI is cut off or no base64; send the whole file."
            ) from error
        home = self._folder / hashlib.sha256(stored).hexdigest()
        home.mkdir(parents=True, exist_ok=True)
        path = home / f"clip{_suffix_of(stored[:16])}"
        if not path.exists():
            part = home / f".{os.getpid()}-{os.urandom(4).hex()}"
            part.write_bytes(stored)
            part.replace(path)  # two programs may send the same recording at once
        return str(path)


def _suffix_of(beginning: bytes) -> str:
    kinds = (suffix for suffix, (at, mark) in BEGINNINGS.items() if beginning.startswith(mark, at))
    return next(kinds, "")
