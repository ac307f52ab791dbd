"""Manifests: one row per clip of a data set whose layout is its owner's own, such as ToucHD-Sim's.

The public pages of ToucHD-Sim (huggingface.co/datasets/BAAI/ToucHD-Sim) name its sensors, objects
and six actions, but no folders and no files: a manifest says where they are. It is a CSV table, or
JSONL with one object a line, with

    clip_id      any name, once each
    object_id    what is touched: clips are split and averaged by it
    sensor       which sensor; may be empty
    action       rotate_cw, rotate_ccw, slide_left, slide_right, slide_up or slide_down
    frames       in order, parted by ';': images, folders, patterns such as obj/7/*.png; or one
                 recording of any kind `read_clip` takes; relative to the manifest
    background   image of the untouched gel, relative too; may be empty
    fps          frames per second; may be empty

Actions name the motion of the object as displayed.
"""

from __future__ import annotations

import csv
import glob
import io
import json
import os
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.core.clip import MOST_FPS, Clip, Frames
from geotlm_lm.core.errors import UnreadableClip, UsageError, choice_of, nearest
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.labelled_recordings import csv_lines
from geotlm_lm.recordings.frame_order import natural_order
from geotlm_lm.recordings.idle import find_idle
from geotlm_lm.recordings.images import IMAGE_SUFFIXES, folder_images, is_stack, read_still_image
from geotlm_lm.recordings.policy import kept_frames
from geotlm_lm.recordings.read import read_background, read_clip

ACTIONS = {
    "rotate_cw": Motion.CLOCKWISE,
    "rotate_ccw": Motion.COUNTERCLOCKWISE,
    "slide_left": Motion.LEFT,
    "slide_right": Motion.RIGHT,
    "slide_up": Motion.UP,
    "slide_down": Motion.DOWN,
}
"""The six atomic actions of ToucHD-Sim -> motions."""

COLUMNS = ("clip_id", "object_id", "sensor", "action", "frames", "background", "fps")
REQUIRED = ("clip_id", "object_id", "action", "frames")
SUFFIXES = (".csv", ".jsonl")

GROUPS = ("object", "sensor", "action", "trial", "frame")
"""Of a pattern over paths; object and action are needed."""

GIVEN, FOUND, NONE = "given", "the clip's own untouched frames", "none, each method guesses it"
"""Where a clip's background comes from, as reports say it."""


@dataclass(frozen=True)
class ManifestRow:
    """One clip of a manifest, with the motion that its action means; paths are relative to it."""

    clip_id: str
    object_id: str
    sensor: str
    motion: Motion
    frames: tuple[str, ...]
    background: str | None = None
    fps: float | None = None


def write_manifest(path: Path, rows: Iterable[ManifestRow]) -> None:
    """Write a manifest, as JSONL where the name ends so, else as CSV.

    Raises:
        UsageError: If a path holds the sign that parts frames in a CSV.
    """
    names = {motion: action for action, motion in ACTIONS.items()}
    written = [
        {
            "clip_id": row.clip_id,
            "object_id": row.object_id,
            "sensor": row.sensor,
            "action": names[row.motion],
            "frames": list(row.frames),
            "background": row.background or "",
            "fps": "" if row.fps is None else f"{row.fps:g}",
        }
        for row in rows
    ]
    if path.suffix.lower() == ".jsonl":
        lines = (json.dumps(values) + "\n" for values in written)
        write_text_atomically(path, "".join(lines))
        return
    parted = [entry for values in written for entry in values["frames"] if ";" in entry]
    if parted:
        raise UsageError(
            f"{parted[0]}: a path with ';' cannot stand in a CSV, which parts frames by it; name "
            f"the manifest .jsonl."
        )
    stream = io.StringIO()
    table = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
    table.writeheader()
    table.writerows(values | {"frames": ";".join(values["frames"])} for values in written)
    write_text_atomically(path, stream.getvalue())


def _json_lines(path: Path) -> list[tuple[int, dict[str, Any]]]:
    lines = []
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        try:
            values = json.loads(line)
        except (ValueError, RecursionError):
            values = None
        if not isinstance(values, dict) or any(name not in values for name in REQUIRED):
            raise UnreadableClip(
                f"{path}:{number}: is no JSON object with {', '.join(REQUIRED)}; correct it."
            )
        lines.append((number, values))
    return lines


def _row(where: str, values: dict[str, Any]) -> ManifestRow:
    def text(name: str) -> str:
        return str(values.get(name) if values.get(name) is not None else "").strip()

    action = text("action")
    if action not in ACTIONS:
        raise UnreadableClip(
            f"{where}: the action '{action}' is not known; {choice_of(action, ACTIONS)}"
        )
    listed = values["frames"]
    entries = listed if isinstance(listed, list) else str(listed or "").split(";")
    frames = tuple(entry.strip() for entry in map(str, entries) if entry.strip())
    if not frames or not text("clip_id") or not text("object_id"):
        raise UnreadableClip(
            f"{where}: clip_id, object_id or frames is empty; name the clip, the object and the "
            f"files."
        )
    background = text("background") or None
    if any("\0" in name for name in (*frames, background or "")):
        raise UnreadableClip(f"{where}: a path holds a zero byte, expected text; correct it.")
    try:
        fps = float(text("fps")) if text("fps") else None
    except ValueError:
        fps = 0.0
    # A NaN fails every comparison, so that this refuses it too.
    if fps is not None and not 0 < fps < MOST_FPS:
        raise UnreadableClip(
            f"{where}: '{text('fps')}' frames per second, expected a number above 0 or nothing; "
            f"correct it."
        )
    return ManifestRow(
        text("clip_id"), text("object_id"), text("sensor"), ACTIONS[action], frames, background, fps
    )


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
        """Read the clips of some motions one at a time; one that cannot be read is left out."""
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
        UnreadableClip: If it is missing or no manifest, a row says something unusable, or a clip
            stands in it twice.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        raise UnreadableClip(
            f"{path}: is no manifest, expected a {' or '.join(SUFFIXES)} file with one row per "
            f"clip; write one with `geotlm-lm manifest`."
        )
    try:
        if path.suffix.lower() == ".csv":
            columns, lines = csv_lines(path, "write it with `geotlm-lm manifest`")
        else:
            columns, lines = COLUMNS, _json_lines(path)
    except OSError as error:
        raise UnreadableClip(
            f"{path}: cannot be opened ({error.strerror}); check its permissions."
        ) from error
    missing = [name for name in REQUIRED if name not in columns]
    if missing:
        if near := nearest(missing[0], [name for name in columns if name not in COLUMNS]):
            raise UnreadableClip(
                f"{path}: lacks the column {missing[0]}; did you mean it by '{near}'?"
            )
        raise UnreadableClip(
            f"{path}: lacks the column{'s' * (len(missing) > 1)} {', '.join(missing)}, expected "
            f"{', '.join(COLUMNS)}; write it with `geotlm-lm manifest`."
        )
    rows = tuple(_row(f"{path}:{line}", values) for line, values in lines)
    if not rows:
        raise UnreadableClip(f"{path}: holds no row; write one with `geotlm-lm manifest`.")
    twice = [name for name, count in Counter(row.clip_id for row in rows).items() if count > 1]
    if twice:
        raise UnreadableClip(
            f"{path}: the clip '{twice[0]}' stands in it more than once, expected every clip_id "
            f"once; rename one."
        )
    return Manifest(path, rows)


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
    beside = next((images.idle for images in folders if images.idle is not None), None)
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


@dataclass(frozen=True)
class MadeManifest:
    """What a pattern found."""

    rows: tuple[ManifestRow, ...]  # one per clip, in natural order of their names
    unmatched: tuple[Path, ...]  # images whose paths the pattern does not fit
    too_short: tuple[str, ...]  # clips of fewer than two frames; they get no row


def make_manifest(
    root: Path,
    pattern: str,
    *,
    relative_to: Path | None = None,
    background_frame: str | None = None,
    actions: Mapping[str, str] | None = None,
    fps: float | None = None,
) -> MadeManifest:
    """Gather the images below `root` into clips.

    Args:
        root: Folder of the data set.
        pattern: Regular expression over a file's path below `root`, with '/' between folders and
            the named groups object, action and, where there are such, sensor, trial and frame. A
            clip is what agrees in all but the frame; frames stand in natural order.
        relative_to: Folder the manifest will lie in; None is `root`.
        background_frame: What `frame` says of the picture of the untouched gel, if one lies among
            a clip's frames; it becomes the background.
        actions: Other names of actions -> those of `ACTIONS`.
        fps: Frames per second, if known.

    Raises:
        UnreadableClip: If `root` holds no image the pattern fits.
        UsageError: If the pattern is none, lacks a group, or finds an action that is not known.
    """
    matcher = _compiled(pattern, background_frame)
    for word, action in (actions or {}).items():
        if action not in ACTIONS:
            raise UsageError(f"'{word}' is to mean '{action}'; {choice_of(action, ACTIONS)}")
    words = {name: name for name in ACTIONS} | dict(actions or {})
    clips: dict[tuple[str, ...], list[tuple[str | None, Path]]] = defaultdict(list)
    unmatched = []
    for path in _images(root):
        match = matcher.search(path.relative_to(root).as_posix())
        if match is None:
            unmatched.append(path)
            continue
        groups = match.groupdict()
        key = tuple(groups.get(name) or "" for name in GROUPS[:-1])
        clips[key].append((groups.get("frame"), path))
    if not clips:
        raise UnreadableClip(
            f"{root}: the pattern fits none of {len(unmatched)} images, the first of them "
            f"{unmatched[0].relative_to(root).as_posix() if unmatched else 'not there'}; write one "
            f"such as '(?P<object>[^/]+)/(?P<action>[^/]+)/(?P<frame>[0-9]+)[.]png'."
        )
    _require_known(clips, words)
    base = relative_to or root
    rows, too_short = [], []
    for key, frames in clips.items():
        row = _row_of(key, frames, words, base, background_frame, fps)
        if len(row.frames) < 2:
            too_short.append(row.clip_id)
        else:
            rows.append(row)
    return MadeManifest(tuple(rows), tuple(unmatched), tuple(too_short))


def _compiled(pattern: str, background_frame: str | None) -> re.Pattern[str]:
    try:
        matcher = re.compile(pattern)
    except re.error as error:
        raise UsageError(
            f"the pattern '{pattern[:80]}' is no regular expression ({error}); correct it."
        ) from error
    needed = ("object", "action") + ("frame",) * (background_frame is not None)
    missing = [name for name in needed if name not in matcher.groupindex]
    strange = [name for name in matcher.groupindex if name not in GROUPS]
    if missing or strange:
        fault = f"lacks the group {missing[0]}" if missing else f"has the group {strange[0]}"
        raise UsageError(
            f"the pattern '{pattern[:80]}' {fault}, expected named groups such as "
            f"(?P<object>...) out of {', '.join(GROUPS)}; object and action are needed."
        )
    return matcher


def _require_known(clips: Mapping[tuple[str, ...], list], words: Mapping[str, str]) -> None:
    """Refuse actions without a meaning: left out silently they would skew what is measured."""
    place = GROUPS.index("action")
    unknown: Counter[str] = Counter()
    for key, frames in clips.items():
        if key[place] not in words:
            unknown[key[place]] += len(frames)
    if unknown:
        actions = ", ".join(f"'{word}' ({count} images)" for word, count in unknown.items())
        raise UsageError(
            f"found the actions {actions}, expected {', '.join(words)}; say what they mean with "
            f"--action WORD=ACTION, or narrow the pattern."
        )


def _row_of(
    key: tuple[str, ...],
    frames: list[tuple[str | None, Path]],
    words: Mapping[str, str],
    base: Path,
    background_frame: str | None,
    fps: float | None,
) -> ManifestRow:
    object_id, sensor, action, trial = key
    # Where the pattern names no frame, the whole path stands in for its number.
    names = [frame or path.with_suffix("").as_posix() for frame, path in frames]
    ordered = [frames[place] for place in natural_order(names)]
    idles = [path for frame, path in ordered if frame is not None and frame == background_frame]
    shown = [path for _, path in ordered if path not in idles]

    def relative(path: Path) -> str:
        return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()

    return ManifestRow(
        clip_id="/".join(part for part in key if part),
        object_id=object_id,
        sensor=sensor,
        motion=ACTIONS[words[action]],
        frames=tuple(map(relative, shown)),
        background=relative(idles[0]) if idles else None,
        fps=fps,
    )


def _images(root: Path) -> list[Path]:
    if not root.is_dir():
        raise UnreadableClip(f"{root}: no such folder; give the one the data set lies in.")
    files = [
        path
        for path in root.rglob("*")
        if path.suffix.lower() in IMAGE_SUFFIXES and not path.name.startswith(".")
    ]
    stems = [path.relative_to(root).with_suffix("").as_posix() for path in files]
    return [files[place] for place in natural_order(stems)]
