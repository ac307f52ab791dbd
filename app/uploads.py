"""Which recordings a program may name: what it sent to this server, and nothing else."""

from __future__ import annotations

import base64
import binascii
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal
from urllib.parse import unquote, urlsplit

from typing_extensions import TypedDict

from geotlm_lm import GeoTLMError

from .limits import INLINE_BYTES, MIB

FILE_ROUTE = "/gradio_api/file="
"""What the toolkit puts before the path of an upload."""

BEGINNINGS = {
    ".npy": (0, b"\x93NUMPY"),
    ".npz": (0, b"PK\x03\x04"),
    ".avi": (8, b"AVI "),
    ".mp4": (4, b"ftyp"),
    ".gif": (0, b"GIF8"),
    ".mkv": (0, b"\x1a\x45\xdf\xa3"),
    ".mcap": (0, b"\x89MCAP0\r\n"),
    ".db3": (0, b"SQLite format 3\0"),
    ".bag": (0, b"#ROSBAG V2.0"),
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
        folder: That uploads are put in; it is made if missing.
    """

    def __init__(self, folder: str | Path) -> None:
        self._folder = Path(folder).resolve()
        self._folder.mkdir(parents=True, exist_ok=True)

    def holds(self, given: Any) -> bool:
        """Tell whether an upload was given, as `path_of` takes it."""
        try:
            path = Path(path_in(given))
            return path.is_absolute() and path.resolve().is_relative_to(self._folder)
        except (OSError, ValueError, TypeError):  # no path at all: too long, or with a null byte
            return False

    def path_of(self, given: Any) -> str:
        """Return the path of an upload; nothing else on this machine is opened.

        Args:
            given: What the Python client sends, or the path or the address of an upload.

        Raises:
            GeoTLMError: If it is none.
        """
        if not self.holds(given):
            raise GeoTLMError(
                "The clip is no upload; send the file itself, in Python by "
                "handle_file('clip.npz'), or as a data URI in base64."
            )
        return path_in(given)

    @contextmanager
    def unpacked(self, uri: str) -> Iterator[Path]:
        """Yield where the recording in a data URI lies, for as long as it is read.

        Raises:
            GeoTLMError: If it is not in base64, cut off, or too long.
        """
        stored = _stored_in(uri)
        home = Path(tempfile.mkdtemp(prefix="message-", dir=self._folder))
        try:
            path = home / f"clip{_suffix_of(stored[:16])}"
            path.write_bytes(stored)
            yield path
        finally:
            shutil.rmtree(home, ignore_errors=True)


def path_in(given: Any) -> Any:
    """Return the path of an upload that a client sent as a file, or named by its address."""
    path = given.get("path") if isinstance(given, dict) else given
    if isinstance(path, str) and FILE_ROUTE in path:
        return unquote(urlsplit(path).path.split(FILE_ROUTE, 1)[-1])
    return path


def _stored_in(uri: str) -> bytes:
    """Return the file in a data URI."""
    form, _, content = uri.partition(",")
    if not form.endswith(";base64"):
        raise GeoTLMError(
            "The clip's data URI is not in base64; send 'data:;base64,' and the file in base64."
        )
    if len(content) > INLINE_BYTES * 4 // 3 + 4:
        raise GeoTLMError(
            f"The clip is {len(content) * 3 // 4 / MIB:.0f} MiB long, expected at most "
            f"{INLINE_BYTES // MIB} inside a message; upload it and send its address."
        )
    try:
        return base64.b64decode(content, validate=True)
    except (binascii.Error, ValueError) as error:
        raise GeoTLMError(
            "The clip's data URI is cut off or no base64; send the whole file."
        ) from error


def _suffix_of(beginning: bytes) -> str:
    kinds = (suffix for suffix, (at, mark) in BEGINNINGS.items() if beginning.startswith(mark, at))
    return next(kinds, "")
