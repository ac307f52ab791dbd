"""The clips a manifest names (`data.manifest_rows`), read one at a time."""

from __future__ import annotations

import glob
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.manifest_rows import SUFFIXES, ManifestRow, rows_of
from geotlm_lm.recordings.frame_order import natural_order
from geotlm_lm.recordings.idle import find_idle
from geotlm_lm.recordings.images import IMAGE_SUFFIXES, folder_images, is_stack, read_still_image
from geotlm_lm.recordings.policy import kept_frames
from geotlm_lm.recordings.read import read_background, read_clip

GIVEN, FOUND, NONE = "given", "the clip's own untouched frames", "none, each method guesses it"
"""Where a clip's background comes from, as reports say it."""


@dataclass(eq=False)
class Manifest:
    """The clips of a manifest.

    Args:
        path: The manifest.
        rows: One per clip.
        left_out: Clip -> the sentence that says why it cannot be read; filled while reading.
        backgrounds: How many clips had which kind of background; filled while reading.
    """

    path: Path
    rows: tuple[ManifestRow, ...]
    left_out: dict[str, str] = field(default_factory=dict)
    backgrounds: Counter[str] = field(default_factory=Counter)

    def clips(self, among: Sequence[Motion]) -> Iterator[tuple[ManifestRow, Clip]]:
        """Read the clips of some motions one at a time; one that cannot be read is left out, named.

        Args:
            among: The motions wanted.
        """
        for row in self.rows:
            if row.motion not in among:
                continue
            try:
                clip, background = _read(self.path.parent, row)
            except (UnreadableClip, OSError) as error:
                self.left_out[row.clip_id] = str(error)
                continue
            self.backgrounds[background] += 1
            yield row, clip


def read_manifest(path: str | Path) -> Manifest:
    """Read a manifest; its files are looked at when their clips are wanted.

    Raises:
        UnreadableClip: If it is missing, no manifest, or a row of it says something unusable.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        raise UnreadableClip(
            f"{path}: is no manifest, expected a {' or '.join(SUFFIXES)} file with one row per "
            f"clip; write one with `geotlm-lm manifest`."
        )
    try:
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise UnreadableClip(
            f"{path}: cannot be opened ({error.strerror}); check its permissions."
        ) from error
    return Manifest(path, rows_of(path, text))


def _read(root: Path, row: ManifestRow) -> tuple[Clip, str]:
    """Return a clip with its background if there is one, and where that comes from."""
    paths = [path for entry in row.frames for path in _files_of(root, entry)]
    is_stills = all(path.suffix.lower() in IMAGE_SUFFIXES and not is_stack(path) for path in paths)
    if len(paths) == 1 and not is_stills:
        clip = replace(read_clip(paths[0], fps=row.fps), name=row.clip_id)
    elif len(paths) < 2 or not is_stills:
        raise UnreadableClip(
            f"{row.clip_id}: its frames name {len(paths)} file{'s' * (len(paths) != 1)}, expected "
            f"2 or more images, or one recording; correct the manifest's row."
        )
    else:
        clip = Clip(_stills(paths), fps=row.fps, name=row.clip_id)
    if row.background is not None:
        return replace(clip, background=read_background(root / row.background)), GIVEN
    if clip.background is not None:
        return clip, GIVEN
    folders = [folder_images(root / entry) for entry in row.frames if (root / entry).is_dir()]
    beside = next((one.idle for one in folders if one.idle is not None), None)
    if beside is not None:
        return replace(clip, background=read_background(beside)), GIVEN
    idle = find_idle(clip)
    return (clip, NONE) if idle is None else (replace(clip, background=idle), FOUND)


def _files_of(root: Path, entry: str) -> list[Path]:
    """Return the files an entry names: itself, a folder's images, or what a pattern matches."""
    path = root / entry
    if path.is_dir():
        return folder_images(path).frames
    if path.exists() or not any(sign in entry for sign in "*?["):
        return [path]
    # An absolute entry stands for itself; signs of a pattern in the manifest's own folder do not.
    pattern = entry if path == Path(entry) else f"{glob.escape(str(root))}/{entry}"
    matches = sorted(map(Path, glob.glob(pattern)))
    places = natural_order([match.with_suffix("").as_posix() for match in matches])
    return [matches[place] for place in places]


def _stills(paths: Sequence[Path]) -> Frames:
    first = read_still_image(paths[0])
    if len(paths) > kept_frames(*first.shape[:2], str(paths[0])):
        raise UnreadableClip(
            f"{paths[0]}: is the first of {len(paths)} frames of a clip, more than fit in memory; "
            f"name fewer of them in the manifest."
        )
    frames = [first, *map(read_still_image, paths[1:])]
    for path, frame in zip(paths, frames, strict=True):
        if frame.shape != frames[0].shape:
            raise UnreadableClip(
                f"{path}: is {frame.shape[1]}x{frame.shape[0]} pixels, {paths[0].name} is "
                f"{frames[0].shape[1]}x{frames[0].shape[0]}; keep frames of one size in a clip."
            )
    return np.stack(frames)
