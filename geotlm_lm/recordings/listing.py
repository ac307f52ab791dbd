"""The recordings of a folder, by name; only a TIFF is opened, for how many pages it has."""

from __future__ import annotations

import os
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.bags import is_bag
from geotlm_lm.recordings.images import IMAGE_SUFFIXES, listed
from geotlm_lm.recordings.read import CLIP_SUFFIXES
from geotlm_lm.recordings.stacks import STACK_SUFFIXES, is_stack

EXPECTED = f"{', '.join(CLIP_SUFFIXES)} or folders of images"
"""What a recording is, for sentences."""


def clips_in(folder: Path) -> list[Path]:
    """Return every recording of a folder, by name: known files, bags, folders of images.

    A TIFF counts as one where it has several pages.

    Raises:
        UnreadableClip: If there is no such folder, it cannot be opened, or nothing in it looks like
            a recording.
    """
    seen = _seen_in(folder)
    found = [one for one in seen if _is_recording(one)]
    images = [one for one in seen if one.suffix.lower() in IMAGE_SUFFIXES]
    if images and not found:
        raise UnreadableClip(
            f"{folder}: holds images, which are frames of one recording, expected a folder of "
            f"recordings: {EXPECTED}; give the folder that this one lies in."
        )
    if not found:
        raise UnreadableClip(
            f"{folder}: holds no recording, expected {EXPECTED}; give the folder they lie in."
        )
    return found


def skipped_in(folder: Path) -> list[Path]:
    """Return what `clips_in` leaves out, by name; hidden files are not told.

    Raises:
        UnreadableClip: If there is no such folder, or it cannot be opened.
    """
    return [one for one in _seen_in(folder) if not _is_recording(one)]


def _seen_in(folder: Path) -> list[Path]:
    if not os.path.isdir(folder):  # unlike the path's own, it raises nothing
        found = "is a file, expected a folder" if os.path.exists(folder) else "no such folder"
        raise UnreadableClip(f"{folder}: {found}; give the one your recordings lie in.")
    return sorted(one for one in listed(folder) if not one.name.startswith("."))


def _is_recording(path: Path) -> bool:
    if not path.is_dir():
        suffix = path.suffix.lower()
        return is_stack(path) if suffix in STACK_SUFFIXES else suffix in CLIP_SUFFIXES
    if is_bag(path):
        return True
    try:
        return any(Path(name).suffix.lower() in IMAGE_SUFFIXES for name in os.listdir(path))
    except OSError:
        return True  # whoever reads it is told why it cannot be
