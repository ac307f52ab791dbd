"""A recording that is named now and read later, perhaps by another process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from geotlm_lm.core.clip import Clip
from geotlm_lm.recordings.read import read_clip


@dataclass(frozen=True)
class StoredRecording:
    """A recording on disk.

    Args:
        path: Where it lies.
        reading: Options of `read_clip`; those left out are as each file says.
    """

    path: Path
    reading: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Of the file or folder."""
        return self.path.name

    def read(self) -> Clip:
        """Return its frames; as of `read_clip`."""
        return read_clip(self.path, **self.reading)

    @property
    def seen_at(self) -> Path:
        """What a machine that reads it must have: the folder, as the file may be gone by now."""
        return self.path.parent

    def stamp(self) -> list[Any]:
        """Return what changes when the file does or is read otherwise, plain JSON values."""
        return [self.name, stamp_of(self.path), dict(self.reading)]


def stamp_of(path: Path) -> list[int]:
    """Return a file's size and time of change; nothing of a link that leads nowhere."""
    try:
        about = path.stat()
    except OSError:
        return []
    return [about.st_size, about.st_mtime_ns]
