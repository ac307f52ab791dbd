"""Frames from the pages of one TIFF file, as microscopes' and cameras' programs save recordings."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.files import plain_name
from geotlm_lm.core.image_size import page_sizes
from geotlm_lm.recordings.decoding import AS_STORED, quiet_decoders, rgb_of_8_bits
from geotlm_lm.recordings.limits import DECODED_FRAMES, kept_frames, stride_for, stride_note
from geotlm_lm.recordings.stated_shape import image_shape

STACK_SUFFIXES = (".tif", ".tiff")

_AT_ONCE = 32
"""Pages decoded before those between the kept ones are let go."""


def is_stack(path: Path) -> bool:
    """Tell whether a file is a TIFF of two pages or more; only its directories are read.

    False of a file that cannot be opened.
    """
    if path.suffix.lower() not in STACK_SUFFIXES:
        return False
    try:
        with path.open("rb") as file:
            return len(page_sizes(file, most=2)) > 1
    except OSError:
        return False


def read_stack(path: Path) -> Clip:
    """Return the clip of the pages of a TIFF.

    Raises:
        UnreadableClip: If it has fewer than two pages, one is damaged, or their sizes differ.
    """
    name = str(path)
    with path.open("rb") as file:
        sizes = page_sizes(file, most=DECODED_FRAMES + 1)
    if None in sizes or not sizes:
        raise _damaged(name)
    if len(sizes) == 1:
        raise UnreadableClip(
            f"{name}: only 1 frame was found, motion needs 2 or more; give the folder it lies in."
        )
    is_whole = len(sizes) <= DECODED_FRAMES
    sizes = sizes[:DECODED_FRAMES]
    other = next((size for size in sizes if size != sizes[0]), None)
    if other is not None:
        raise UnreadableClip(
            f"{name}: page {sizes.index(other) + 1} is {other[1]}x{other[0]} pixels, page 1 is "
            f"{sizes[0][1]}x{sizes[0][0]}; keep frames of one recording in the file."
        )
    kept_frames(*sizes[0], name)
    with path.open("rb") as file:
        shape = image_shape(file)
    stride = stride_for(len(sizes), *shape.shown_size(*sizes[0]), name)
    pages = rgb_of_8_bits(_decoded(path, len(sizes), stride), name)
    frames = np.stack([shape.squared(page, name) for page in pages])
    notes = [f"{len(sizes)} pages were read as frames.", *shape.notes]
    if stride > 1:
        notes.append(stride_note(stride, len(sizes)))
    if not is_whole:
        notes.append(f"Only the first {len(sizes)} frames were read; cut the recording.")
    numbers = tuple(range(0, len(sizes), stride))
    return Clip(
        frames,
        name=name,
        frame_numbers=numbers,
        notes=tuple(notes),
        recorded_frames=len(sizes),
    )


def _decoded(path: Path, count: int, stride: int) -> list[np.ndarray]:
    kept: list[np.ndarray] = []
    for start in range(0, count, _AT_ONCE):
        asked = min(_AT_ONCE, count - start)
        try:
            with quiet_decoders(), plain_name(path) as plain:
                is_read, pages = cv2.imreadmulti(plain, start, asked, flags=AS_STORED)
        except cv2.error:
            is_read, pages = False, ()
        if not is_read or len(pages) < asked or len({page.shape for page in pages}) > 1:
            raise _damaged(str(path))
        kept += pages[-start % stride :: stride]
    return kept


def _damaged(name: str) -> UnreadableClip:
    return UnreadableClip(
        f"{name}: is cut off or is no TIFF of whole pages; copy or record it again."
    )
