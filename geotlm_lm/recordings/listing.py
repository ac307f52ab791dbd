"""The recordings of a folder, by name; opens none of them."""

from __future__ import annotations

import os
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.images import IMAGE_SUFFIXES
from geotlm_lm.recordings.read import ARRAY_SUFFIXES
from geotlm_lm.recordings.video import VIDEO_SUFFIXES

CLIP_SUFFIXES = (*ARRAY_SUFFIXES, *VIDEO_SUFFIXES)


def clips_in(folder: Path) -> list[Path]:
    """Return every recording of a folder, by name: files of known endings and folders of images.

    Raises:
        UnreadableClip: If there is no such folder, or nothing in it looks like a recording.
    """
    if not folder.is_dir():
        raise UnreadableClip(f"{folder}: no such folder; give the one your recordings lie in.")
    found = [one for one in sorted(folder.iterdir()) if _is_recording(one)]
    if not found:
        raise UnreadableClip(
            f"{folder}: holds no recording, expected {', '.join(CLIP_SUFFIXES)} or folders of "
            f"images; give the folder they lie in."
        )
    return found


def _is_recording(path: Path) -> bool:
    if path.name.startswith("."):
        return False
    if not path.is_dir():
        return path.suffix.lower() in CLIP_SUFFIXES
    try:
        return any(Path(name).suffix.lower() in IMAGE_SUFFIXES for name in os.listdir(path))
    except OSError:
        return True  # whoever reads it is told why it cannot be
