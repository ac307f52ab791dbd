"""What a recording will take in memory by what its headers say: known before any of it is read."""

from __future__ import annotations

import math
from pathlib import Path

import cv2

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.image_size import declared_size, page_sizes
from geotlm_lm.recordings.arrays import declared_frames
from geotlm_lm.recordings.bags import is_bag
from geotlm_lm.recordings.images import folder_images
from geotlm_lm.recordings.limits import DECODED_FRAMES, KEPT_BYTES
from geotlm_lm.recordings.stacks import STACK_SUFFIXES
from geotlm_lm.recordings.video import VIDEO_SUFFIXES
from geotlm_lm.recordings.video_file import GIF, quiet_capture

PACKED_RATIO = 64
"""Times a bag or a GIF unpacks to at most, as is assumed: neither declares what its frames take."""

HEADER_BYTES = 2**20
"""Of an image, in which its size is looked for."""


def declared_bytes(path: Path) -> int:
    """Return the bytes of frames that reading a recording will hold; nothing is decoded.

    Args:
        path: Of a file or a folder.

    Returns:
        As many as are ever kept at most; 0 of what cannot be read, as reading it will tell.
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
    if suffix in (".npy", ".npz"):
        return declared_frames(path)
    if suffix == GIF:
        return PACKED_RATIO * path.stat().st_size
    if suffix in VIDEO_SUFFIXES:
        with quiet_capture(path, cv2.CAP_FFMPEG) as capture:
            sides = (cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_WIDTH)
            rows, columns = (int(capture.get(one)) for one in sides)
            count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        # A container that does not say how many frames it holds may hold as many as fit.
        return 3 * rows * columns * count if count > 0 else KEPT_BYTES * (rows > 0)
    if suffix in STACK_SUFFIXES:
        with path.open("rb") as file:
            return sum(3 * math.prod(size or ()) for size in page_sizes(file, DECODED_FRAMES))
    return 0
