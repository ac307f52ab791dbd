"""A manifest: one row per clip of a data set whose layout is its owner's own, such as ToucHD-Sim's.

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

Actions name the motion of the object as displayed. Knows the table, not the files it names.
"""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geotlm_lm.core.clip import MOST_FPS
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.labels import Motion

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


@dataclass(frozen=True)
class ManifestRow:
    """One clip of a manifest.

    Args:
        clip_id: Its name.
        object_id: What is touched.
        sensor: Which sensor; "" when the manifest is silent.
        motion: What its action means.
        frames: Images, folders, patterns or one recording, relative to the manifest.
        background: Image of the untouched gel, relative; None when the manifest is silent.
        fps: Frames per second; None when the manifest is silent.
    """

    clip_id: str
    object_id: str
    sensor: str
    motion: Motion
    frames: tuple[str, ...]
    background: str | None = None
    fps: float | None = None


def rows_of(path: Path, text: str) -> tuple[ManifestRow, ...]:
    """Return the rows of a manifest's text.

    Args:
        path: Its name: the ending tells the format, errors name it.
        text: What stands in it.

    Raises:
        UnreadableClip: If a row says something unusable, there is none, or a clip stands twice.
    """
    table = _csv_rows(path, text) if path.suffix.lower() == ".csv" else _json_rows(path, text)
    rows = [_row(f"{path}:{line}", values) for line, values in table]
    if not rows:
        raise UnreadableClip(f"{path}: holds no row; write one with `geotlm-lm manifest`.")
    twice = [name for name, count in Counter(row.clip_id for row in rows).items() if count > 1]
    if twice:
        raise UnreadableClip(
            f"{path}: the clip '{twice[0]}' stands in it more than once, expected every clip_id "
            f"once; rename one."
        )
    return tuple(rows)


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


def _csv_rows(path: Path, text: str) -> Iterator[tuple[int, dict[str, Any]]]:
    reader = csv.DictReader(io.StringIO(text))
    try:
        rows, columns = [(reader.line_num, dict(row)) for row in reader], reader.fieldnames or ()
    except csv.Error as error:
        raise UnreadableClip(
            f"{path}: is no table ({error} in line {reader.line_num}); write it with `geotlm-lm "
            f"manifest`."
        ) from error
    missing = [name for name in REQUIRED if name not in columns]
    if missing:
        raise UnreadableClip(
            f"{path}: lacks the column{'s' * (len(missing) > 1)} {', '.join(missing)}, expected "
            f"{', '.join(COLUMNS)}; write it with `geotlm-lm manifest`."
        )
    yield from rows


def _json_rows(path: Path, text: str) -> Iterator[tuple[int, dict[str, Any]]]:
    for line, row in enumerate(text.splitlines(), start=1):
        if not row.strip():
            continue
        try:
            values = json.loads(row)
        except (ValueError, RecursionError):
            values = None
        if not isinstance(values, dict) or any(name not in values for name in REQUIRED):
            raise UnreadableClip(
                f"{path}:{line}: is no JSON object with {', '.join(REQUIRED)}; correct it."
            )
        yield line, values


def _row(where: str, values: dict[str, Any]) -> ManifestRow:
    def text(name: str) -> str:
        return str(values.get(name) if values.get(name) is not None else "").strip()

    action = text("action")
    if action not in ACTIONS:
        raise UnreadableClip(
            f"{where}: the action '{action}' is not known, expected one of {', '.join(ACTIONS)}; "
            f"correct it, or leave the row out."
        )
    listed = values["frames"]
    entries = listed if isinstance(listed, list) else str(listed or "").split(";")
    frames = tuple(entry.strip() for entry in map(str, entries) if entry.strip())
    if not frames or not text("clip_id") or not text("object_id"):
        raise UnreadableClip(
            f"{where}: clip_id, object_id or frames is empty; name the clip, the object and the "
            f"files."
        )
    background, fps = text("background") or None, _fps(where, text("fps"))
    if any("\0" in name for name in (*frames, background or "")):
        raise UnreadableClip(f"{where}: a path holds a zero byte, expected text; correct it.")
    return ManifestRow(
        text("clip_id"), text("object_id"), text("sensor"), ACTIONS[action], frames, background, fps
    )


def _fps(where: str, text: str) -> float | None:
    try:
        fps = float(text) if text else None
    except ValueError:
        fps = 0.0
    # A NaN fails every comparison, so that this refuses it too.
    if fps is not None and not 0 < fps < MOST_FPS:
        raise UnreadableClip(
            f"{where}: '{text}' frames per second, expected a number above 0 or nothing; correct "
            f"it."
        )
    return fps
