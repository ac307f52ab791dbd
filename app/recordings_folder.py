"""The folder of recordings that a server was started with: read only, and no way out of it."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from geotlm_lm import CLIP_SUFFIXES, IMAGE_SUFFIXES, GeoTLMError

from .limits import LISTED, MIB, UPLOAD_BYTES

IMAGES = "images"
"""Kind of a recording that is a folder of images."""


@dataclass(frozen=True)
class Stored:
    """A recording in the folder.

    Args:
        name: Its path in the folder, with "/".
        kind: Its ending without the dot, or "images" for a folder of them.
        size_bytes: Of the file, or of all images.
    """

    name: str
    kind: str
    size_bytes: int


class RecordingsFolder:
    """Lists recordings and finds them by name; what it does not list it does not open.

    Args:
        root: The folder; a symbolic link to it is followed, none inside it is.

    Raises:
        GeoTLMError: If it is no folder.
    """

    def __init__(self, root: Path) -> None:
        if not root.is_dir():
            raise GeoTLMError(
                f"--recordings {root} is no folder; give the folder that your recordings lie in."
            )
        self._root = root.resolve()

    def listing(self) -> tuple[list[Stored], bool]:
        """Return the recordings by name, and whether there are more than can be listed."""
        found: list[Stored] = []
        for one in self._stored():
            if len(found) == LISTED:
                return found, True
            found.append(one)
        return found, False

    def path_of(self, name: str) -> Path:
        """Return where a recording lies.

        Args:
            name: As listed.

        Raises:
            GeoTLMError: If there is none of this name, or it is too long.
        """
        # The name is looked for in its own folder's listing, never joined to a path and followed.
        *folders, last = name.split("/")
        place = self._root
        for folder in folders:
            if folder not in _plain_names(place, (True,)):
                raise _unknown(name)
            place /= folder
        stored = (
            _recording(place / last, name) if last in _plain_names(place, (True, False)) else None
        )
        if stored is None:
            raise _unknown(name)
        if stored.size_bytes > UPLOAD_BYTES:
            raise GeoTLMError(
                f"{name} is {stored.size_bytes // MIB} MiB long, expected at most "
                f"{UPLOAD_BYTES // MIB}; cut the recording."
            )
        return place / last

    def _stored(self) -> Iterator[Stored]:
        for place, folders, names in os.walk(self._root):
            folders[:] = sorted(one for one in folders if _is_plain(Path(place, one), True))
            for last in sorted([*names, *folders]):
                path = Path(place, last)
                if stored := _recording(path, path.relative_to(self._root).as_posix()):
                    yield stored


def _recording(path: Path, name: str) -> Stored | None:
    """Return what a path holds; None where it is no recording, hidden, a link or unreadable.

    Nor is it one under a name that is no text: nobody could be told it.
    """
    try:
        name.encode()
        return _stored_at(path, name)
    except (OSError, UnicodeEncodeError):
        return None


def _stored_at(path: Path, name: str) -> Stored | None:
    if _is_plain(path, False):
        suffix = path.suffix.lower()
        kind = suffix[1:] if suffix in CLIP_SUFFIXES else ""
        return Stored(name, kind, path.stat().st_size) if kind else None
    if not _is_plain(path, True):
        return None
    held = [path / one for one in os.listdir(path)]
    images = [one for one in held if one.suffix.lower() in IMAGE_SUFFIXES]
    if len(images) < 2 or not all(_is_plain(one, False) for one in images):
        return None
    return Stored(name, IMAGES, sum(one.stat().st_size for one in images))


def _plain_names(place: Path, kinds: tuple[bool, ...]) -> list[str]:
    """Return the names in a folder of its folders (True), its files (False), or both."""
    try:
        names = os.listdir(place)
    except OSError:
        return []
    return [one for one in names if any(_is_plain(place / one, kind) for kind in kinds)]


def _is_plain(path: Path, is_folder: bool) -> bool:
    """Tell whether a path is a file, or a folder, itself: not hidden, no link, no device."""
    try:
        mode = path.lstat().st_mode
    except OSError:
        return False
    is_kind = stat.S_ISDIR(mode) if is_folder else stat.S_ISREG(mode)
    return is_kind and not path.name.startswith(".")


def _unknown(name: str) -> GeoTLMError:
    return GeoTLMError(
        f"There is no recording {name[:80]!r}; the tool recordings lists the names there are."
    )
