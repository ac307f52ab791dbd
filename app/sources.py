"""Which recordings a tool may be given: a name that is listed, a data URI, or an upload.

Nothing else on this machine is opened: no path, no link, nothing outside the folder that is served.
"""

from __future__ import annotations

import base64
import binascii
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, Literal
from urllib.parse import unquote, urlsplit

from typing_extensions import TypedDict

import geotlm_lm as lm
from geotlm_lm.core.errors import nearest

from .guards import INLINE_BYTES, LISTED, MIB, NAME_CHARACTERS, UPLOAD_BYTES
from .schema import Listing, StoredRecording

EXAMPLE_FOLDER = Path(__file__).parent / "examples"

RECORDING_FOLDER = Path(__file__).parent / "recordings"

EXAMPLES = {f"example:{path.stem}": path for path in sorted(EXAMPLE_FOLDER.glob("*.npz"))} | {
    f"example:recording_{path.stem}": path for path in sorted(RECORDING_FOLDER.glob("*.mov"))
}
"""Paths of the recordings on offer, by the names that tools take."""

FIRST = "recording_key"
"""Opened with the page: a touch, a turn there and back, a slip and a release."""

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


@dataclass(frozen=True)
class Source:
    """Where a recording comes from, and which part of it is read."""

    path: Any  # of several images of it, a list; None of what lies in no file
    name: str
    example: str | None = None  # its key, where it is one
    span: tuple[int, int] | None = None  # first and last frame, where only a part was read
    topic: str | None = None
    notes: tuple[str, ...] = ()  # that stand below its picture


@cache
def examples() -> dict[str, Source]:
    """Return what is on offer by keys, whole recordings before clips, the first opened first.

    They are named after what is touched: how it moves is for the model to tell.
    """
    offer: dict[str, Source] = {}
    for path in sorted(RECORDING_FOLDER.glob("*.mov")):
        key = f"recording_{path.stem}"
        offer[key] = Source(str(path), path.stem.replace("_", " "), key)
    offer = dict(sorted(offer.items(), key=lambda item: item[0] != FIRST))
    for path in EXAMPLES.values():
        if path.parent == RECORDING_FOLDER:
            continue
        touched = path.stem
        for motion in sorted(lm.Motion, key=lambda motion: -len(motion)):
            touched = touched.removesuffix(f"_{motion.value}")
        count = 1 + sum(key.rstrip("_23456789") == touched for key in offer)
        key = touched if count == 1 else f"{touched}_{count}"
        offer[key] = Source(str(path), key.replace("_", " "), key)
    return offer


class UploadMeta(TypedDict):
    """Marks an upload for the toolkit."""

    _type: Literal["gradio.FileData"]


class Upload(TypedDict):
    """A file as the Python client sends it."""

    path: str
    meta: UploadMeta


def path_in(given: Any) -> Any:
    """Return the path of an upload that a client sent as a file, or named by its address."""
    path = given.get("path") if isinstance(given, dict) else given
    if isinstance(path, str) and FILE_ROUTE in path:
        return unquote(urlsplit(path).path.split(FILE_ROUTE, 1)[-1])
    return path


class Sources:
    """Finds a recording, whatever it was given as.

    The recordings in the folder that is served are listed by name; a symbolic link to it is
    followed, none inside it is.
    """

    def __init__(self, uploads: str | Path, served: Path | None = None) -> None:
        if served is not None and not served.is_dir():
            raise lm.GeoTLMError(
                f"--recordings {served} is no folder; give the folder that your recordings lie in."
            )
        self._uploads = Path(uploads).resolve()
        self._uploads.mkdir(parents=True, exist_ok=True)
        self._served = None if served is None else served.resolve()

    def listing(self) -> Listing:
        """Return the names that can be given, with the kind and the size of each."""
        stored = list(islice(self._stored(), LISTED + 1))
        return {
            "recordings": [
                recording | _length(self._served / recording["name"])
                for recording in stored[:LISTED]
            ],
            "examples": [
                {"name": name, "kind": path.suffix[1:], "size_bytes": path.stat().st_size}
                | _length(path)
                for name, path in EXAMPLES.items()
            ],
            "is_folder_served": self._served is not None,
            "has_more": len(stored) > LISTED,
        }

    @contextmanager
    def opened(self, given: str) -> Iterator[Path]:
        """Yield where a recording lies; one that came inside a message is removed afterwards.

        Raises:
            GeoTLMError: If it is none that can be given, in one sentence.
        """
        if given.startswith("data:"):
            with self._unpacked(given) as path:
                yield path
        elif given.startswith("example:"):
            if given not in EXAMPLES:
                raise lm.GeoTLMError(f"There is no example {given[:80]!r}; {self._advice(given)}")
            yield EXAMPLES[given]
        elif self.is_upload(given):
            path = Path(path_in(given))
            if not path.is_file():
                raise lm.GeoTLMError(
                    "The upload is not on the server any more; send the file again."
                )
            yield path
        else:
            yield self._named(given)

    def is_upload(self, given: Any) -> bool:
        """Tell whether this is the path or the address of an upload, or what a client sends."""
        try:
            path = Path(path_in(given))
            return path.is_absolute() and path.resolve().is_relative_to(self._uploads)
        except (OSError, ValueError, TypeError):  # no path at all: too long, or with a null byte
            return False

    @contextmanager
    def _unpacked(self, uri: str) -> Iterator[Path]:
        """Yield where the recording in a data URI lies, for as long as it is read."""
        stored = _stored_in(uri)
        kinds = (end for end, (at, mark) in BEGINNINGS.items() if stored.startswith(mark, at))
        with tempfile.TemporaryDirectory(prefix="message-", dir=self._uploads) as home:
            path = Path(home) / f"clip{next(kinds, '')}"
            path.write_bytes(stored)
            yield path

    def _named(self, name: str) -> Path:
        if len(name) > NAME_CHARACTERS or "://" in name or name.startswith(("/", "\\")):
            raise lm.GeoTLMError(
                "The recording is neither a name nor a data URI nor an upload; give a name that "
                "the tool recordings lists, or send the file itself, in Python by "
                "handle_file('clip.npz'), elsewhere as 'data:;base64,...'."
            )
        stored = self._stored_at(name)
        if stored is None:
            why = ", as no folder is served" if self._served is None else ""
            raise lm.GeoTLMError(f"There is no recording {name[:80]!r}{why}; {self._advice(name)}")
        if stored["size_bytes"] > UPLOAD_BYTES:
            raise lm.GeoTLMError(
                f"{name} is {stored['size_bytes'] // MIB} MiB long, expected at most "
                f"{UPLOAD_BYTES // MIB}; cut the recording."
            )
        return self._served / name

    def _stored_at(self, name: str) -> StoredRecording | None:
        """Return the recording that is listed by a name: no link and nothing hidden leads to it."""
        if self._served is None:
            return None
        path = self._served / name
        try:
            inside = path.relative_to(self._served)
            is_listed = inside.as_posix() == name and path.resolve(strict=True) == path
        except (OSError, ValueError):
            return None
        is_hidden = any(part.startswith(".") for part in inside.parts)
        return _recording(path, name) if is_listed and not is_hidden else None

    def _advice(self, name: str) -> str:
        """Return how a refusal of an unknown name ends: the nearest of those that are listed."""
        stored = [recording["name"] for recording in islice(self._stored(), LISTED)]
        known = {example.removeprefix("example:"): example for example in EXAMPLES}
        known |= {listed: listed for listed in (*EXAMPLES, *stored)}
        near = nearest(name, known)
        if near is not None:
            return f"did you mean '{known[near]}'?"
        if self._served is not None:
            return "the tool recordings lists the names there are."
        return (
            f"name an example such as {next(iter(EXAMPLES), None)!r}, or start the server with "
            f"--recordings FOLDER."
        )

    def _stored(self) -> Iterator[StoredRecording]:
        for place, folders, names in os.walk(self._served) if self._served else ():
            folders[:] = sorted(name for name in folders if _is_plain(Path(place, name), True))
            for last in sorted([*names, *folders]):
                path = Path(place, last)
                if stored := _recording(path, path.relative_to(self._served).as_posix()):
                    yield stored


def _length(path: Path) -> dict[str, Any]:
    """Return how long a recording is, read once for each state that it is in."""
    return dict(zip(("frames", "fps"), _length_of(path, path.stat().st_mtime_ns), strict=True))


@lru_cache(4 * LISTED)
def _length_of(path: Path, _: int) -> tuple[int | None, float | None]:
    return lm.declared_length(path)


def _recording(path: Path, name: str) -> StoredRecording | None:
    """Return what a path holds; None where it is no recording, hidden, a link or unreadable.

    Nor is it one under a name that is no text, which could not be sent.
    """
    try:
        name.encode()
        if _is_plain(path, False):
            suffix = path.suffix.lower()
            kind, size_bytes = suffix[1:] * (suffix in lm.CLIP_SUFFIXES), path.stat().st_size
        elif _is_plain(path, True):
            entries = [path / entry for entry in os.listdir(path)]
            images = [entry for entry in entries if entry.suffix.lower() in lm.IMAGE_SUFFIXES]
            is_one = len(images) > 1 and all(_is_plain(image, False) for image in images)
            kind = "images" if is_one else ""
            size_bytes = sum(image.stat().st_size for image in images) if is_one else 0
        else:
            return None
    except (OSError, UnicodeEncodeError):
        return None
    return {"name": name, "kind": kind, "size_bytes": size_bytes} if kind else None


def _is_plain(path: Path, is_folder: bool) -> bool:
    """Tell whether a path is a file, or a folder, itself: not hidden, no link, no device."""
    try:
        mode = path.lstat().st_mode
    except OSError:
        return False
    is_kind = stat.S_ISDIR(mode) if is_folder else stat.S_ISREG(mode)
    return is_kind and not path.name.startswith(".")


def _stored_in(uri: str) -> bytes:
    """Return the file in a data URI."""
    form, _, content = uri.partition(",")
    if not form.endswith(";base64"):
        raise lm.GeoTLMError(
            "The clip's data URI is not in base64; send 'data:;base64,' and the file in base64."
        )
    if len(content) > INLINE_BYTES * 4 // 3 + 4:
        raise lm.GeoTLMError(
            f"The clip is {len(content) * 3 // 4 / MIB:.0f} MiB long, expected at most "
            f"{INLINE_BYTES // MIB} inside a message; upload it and send its address."
        )
    try:
        return base64.b64decode(content, validate=True)
    except (binascii.Error, ValueError) as error:
        raise lm.GeoTLMError(
            "The clip's data URI is cut off or no base64; send the whole file."
        ) from error
