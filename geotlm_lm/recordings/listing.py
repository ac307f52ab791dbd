"""Recordings by name: those of a folder, what reading them will take, one to be read later."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.image_size import declared_size, page_sizes
from geotlm_lm.recordings.arrays import ARRAY_SUFFIXES, declared_frames
from geotlm_lm.recordings.bags import is_bag
from geotlm_lm.recordings.images import (
    IMAGE_SUFFIXES,
    STACK_SUFFIXES,
    folder_images,
    is_stack,
    listed,
)
from geotlm_lm.recordings.policy import DECODED_FRAMES, KEPT_BYTES
from geotlm_lm.recordings.read import CLIP_SUFFIXES, read_clip
from geotlm_lm.recordings.video import GIF, VIDEO_SUFFIXES, quiet_capture

EXPECTED = f"{', '.join(CLIP_SUFFIXES)} or folders of images"
"""What a recording is, for sentences."""

PACKED_RATIO = 64
"""Times a bag or a GIF unpacks to at most, as is assumed: neither declares what its frames take."""

HEADER_BYTES = 2**20
"""Of an image, in which its size is looked for."""


def clips_in(folder: Path) -> list[Path]:
    """Return every recording of a folder, by name: known files, bags, folders of images.

    A TIFF counts as one where it has several pages. A folder without any is refused.
    """
    seen = _seen_in(folder)
    recordings = [path for path in seen if _is_recording(path)]
    images = [path for path in seen if path.suffix.lower() in IMAGE_SUFFIXES]
    if images and not recordings:
        raise UnreadableClip(
            f"{folder}: holds images, which are frames of one recording, expected a folder of "
            f"recordings: {EXPECTED}; give the folder that this one lies in."
        )
    if not recordings:
        raise UnreadableClip(
            f"{folder}: holds no recording, expected {EXPECTED}; give the folder they lie in."
        )
    return recordings


def skipped_in(folder: Path) -> list[Path]:
    """Return what `clips_in` leaves out, by name; hidden files are passed over."""
    return [path for path in _seen_in(folder) if not _is_recording(path)]


def _seen_in(folder: Path) -> list[Path]:
    if not os.path.isdir(folder):  # unlike the path's own, it raises nothing
        kind = "is a file, expected a folder" if os.path.exists(folder) else "no such folder"
        raise UnreadableClip(f"{folder}: {kind}; give the one your recordings lie in.")
    return sorted(path for path in listed(folder) if not path.name.startswith("."))


def _is_recording(path: Path) -> bool:
    if not path.is_dir():
        suffix = path.suffix.lower()
        return is_stack(path) if suffix in STACK_SUFFIXES else suffix in CLIP_SUFFIXES
    if is_bag(path):
        return True
    try:
        return any(Path(name).suffix.lower() in IMAGE_SUFFIXES for name in os.listdir(path))
    except OSError:
        return True  # reading it will say why it cannot be opened


def declared_bytes(path: Path) -> int:
    """Return the bytes of frames that reading a recording will hold; nothing is decoded.

    No more than are ever kept; 0 of what cannot be read, as reading it will say.
    """
    try:
        return min(_declared(path), KEPT_BYTES)
    except (UnreadableClip, OSError):
        return 0


def _declared(path: Path) -> int:
    suffix = path.suffix.lower()
    if is_bag(path):
        files = path.iterdir() if path.is_dir() else (path,)
        return PACKED_RATIO * sum(file.stat().st_size for file in files)
    if path.is_dir():
        images = folder_images(path).frames
        if not images:
            return 0
        with images[0].open("rb") as file:
            size = declared_size(file.read(HEADER_BYTES)) or (0, 0)
        return len(images) * 3 * math.prod(size)
    if suffix in ARRAY_SUFFIXES:
        return declared_frames(path)
    if suffix == GIF:
        return PACKED_RATIO * path.stat().st_size
    if suffix in VIDEO_SUFFIXES:
        with quiet_capture(path, cv2.CAP_FFMPEG) as capture:
            sides = (cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_WIDTH)
            rows, columns = (int(capture.get(side)) for side in sides)
            count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        # A container that does not say how many frames it holds may hold as many as fit.
        return 3 * rows * columns * count if count > 0 else KEPT_BYTES * (rows > 0)
    if suffix in STACK_SUFFIXES:
        with path.open("rb") as file:
            return sum(3 * math.prod(size or ()) for size in page_sizes(file, DECODED_FRAMES))
    return 0


@dataclass(frozen=True)
class StoredRecording:
    """A recording on disk, and the options of `read_clip` to read it with."""

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
