"""Files of a LeRobot data set (v3): what `meta/info.json` says, the paths it names, the tables."""

from __future__ import annotations

import json
import os
import re
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from string import Formatter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import MOST_FPS
from geotlm_lm.core.errors import UnreadableClip, first_line
from geotlm_lm.core.files import plain_name

if TYPE_CHECKING:
    import pyarrow

INFO, STATISTICS, EPISODES = "meta/info.json", "meta/stats.json", "meta/episodes"

VERSION, CONVERTED = "v3.", "v2.1"
"""What the version of a layout that is read begins with, and one that LeRobot converts to it."""

PLACE_FIELDS = ("chunk_index", "file_index")

USUAL_PATHS = {
    "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
}

MOST_ROWS = 50_000_000
"""Rows of a table that is read: 19 days of frames, 400 MB a column; a file of many more is small
where they are alike."""

LONGEST_S = 1e8
"""Seconds of a recording at most, 3 years: times beyond are damaged."""

_NUMBER_FORM = re.compile(r"0?[0-9]{0,2}d?")
"""How a number may be filled in: `03d`. A width of many digits would fill the memory."""


def filled(template: str, chunk: int, file: int, camera: str = "") -> str:
    """Return a path from the root on that stays below it, whatever is filled in."""
    numbers = dict(zip(PLACE_FIELDS, (chunk, file), strict=True))
    return str(PurePosixPath(template.format(video_key=camera, **numbers)))


def read_info(root: Path) -> dict[str, Any]:
    """Return what the data set in a folder says of itself, all that is used of it checked.

    A camera's name is one part of a path, and the templates of paths stay below the root.
    """
    path = root / INFO
    if not os.path.isfile(path):
        raise UnreadableClip(
            f"{root}: is no LeRobot data set, expected a readable {INFO}; give the folder that "
            f"holds meta and data."
        )
    content = read_object(path)
    _require_version(root, content.get("codebase_version"))
    fps, total = content.get("fps"), content.get("total_episodes")
    if not _is_number(fps) or not 0 < fps < MOST_FPS:
        raise _senseless(path, "fps", fps, f"a number above 0 and below {MOST_FPS:g}")
    if not _is_number(total) or isinstance(total, float) or total < 0:
        raise _senseless(path, "total_episodes", total, "a whole number")
    kinds = _kinds(path, content.get("features"))
    _require_template(path, content, "data_path", PLACE_FIELDS)
    if "video" in kinds:
        _require_template(path, content, "video_path", (*PLACE_FIELDS, "video_key"))
    return content


def read_object(path: Path) -> dict[str, Any]:
    """Return the JSON object in a file."""
    try:
        content = json.loads(path.read_text(encoding="utf-8")) if os.path.isfile(path) else None
        reason = "it is no file that holds one"
    except (OSError, ValueError, RecursionError) as error:
        content, reason = None, first_line(error)
    if not isinstance(content, dict):
        raise UnreadableClip(
            f"{path}: cannot be read ({reason}), expected a JSON object of a LeRobot data set; "
            f"copy it again."
        )
    return content


def contained(root: Path, name: str) -> Path:
    """Return the path of a file that a data set names; no link of a folder leads out of it.

    The file itself may be a link: a set that was downloaded consists of links into a cache.
    """
    path = root / name
    if not Path(os.path.realpath(path.parent)).is_relative_to(os.path.realpath(root)):
        raise UnreadableClip(
            f"{path}: a link leads out of the data set's folder there, expected folders in it; "
            f"put the files where the link stands."
        )
    return path


def _require_version(root: Path, version: object) -> None:
    if isinstance(version, str) and version.startswith(VERSION):
        return
    advice = "convert it with LeRobot's own script"
    if version == CONVERTED:
        place = shlex.quote(str(root.absolute()))
        advice = (
            "convert it in place, with Python 3.12 or newer, by `pip install "
            "'lerobot[dataset]>=0.6'` and `python -m "
            "lerobot.scripts.convert_dataset_v21_to_v30 --repo-id=local/converted "
            f"--root={place} --push-to-hub=false`"
        )
    raise UnreadableClip(
        f"{root}: is a LeRobot data set of version {_shown(version)}, expected {VERSION}x; "
        f"{advice}."
    )


def _kinds(path: Path, features: object) -> set[str]:
    """Return the types of columns there are, each checked."""
    if not isinstance(features, dict):
        raise _senseless(path, "features", features, "an object with each column's dtype")
    kinds = set()
    for name, feature in features.items():
        kind = feature.get("dtype") if isinstance(feature, dict) else None
        if not isinstance(kind, str):
            raise _senseless(path, f"the dtype of {_shown(name)}", kind, "a text")
        is_part = name == PureWindowsPath(name).name and name != ".." and name.isprintable()
        if kind in ("video", "image") and not is_part:
            raise _senseless(path, "a camera's name", name, "one without slashes")
        kinds.add(kind)
    return kinds


def _require_template(
    path: Path, content: dict[str, Any], name: str, fields: tuple[str, ...]
) -> None:
    text = content.get(name)
    fault = _fault(text, fields) if isinstance(text, str) else "is no text"
    if fault is not None:
        raise UnreadableClip(
            f"{path}: its {name}, {_shown(text)}, {fault}, expected a path below the data set's "
            f"folder such as {USUAL_PATHS[name]}; correct it, or copy the data set again."
        )


def _fault(text: str, fields: tuple[str, ...]) -> str | None:
    """Return what is wrong with a template; None where it always gives a path below the root."""
    try:
        pieces = list(Formatter().parse(text))
    except ValueError as error:
        return f"has wrong braces ({error})"
    for _, field, form, conversion in pieces:
        if field is None:
            continue
        if field not in fields:
            return f"fills in {_shown(field)}"
        is_plain = form == "" if field == "video_key" else _NUMBER_FORM.fullmatch(form)
        if conversion is not None or not is_plain:
            return f"fills in {field} in a form of its own"
    # Any number and any camera's name in place of these leaves the parts what they are.
    tried = text.format(**dict.fromkeys(PLACE_FIELDS, 0), video_key="camera")
    as_windows = PureWindowsPath(tried)
    if as_windows.anchor or not as_windows.parts or ".." in as_windows.parts:
        return "leads out of that folder"
    return None if tried.isprintable() else "holds characters that no path has"


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _senseless(path: Path, what: str, value: object, expected: str) -> UnreadableClip:
    return UnreadableClip(
        f"{path}: {what} is {_shown(value)}, expected {expected}; correct it, or copy the data "
        f"set again."
    )


def _shown(value: object) -> str:
    """Return a value of JSON as an error tells it."""
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "an object"
    return "missing" if value is None else repr(value)[:80]


@dataclass(frozen=True, eq=False)
class FrameTable:
    """Which frame of which episode each row of a table is."""

    path: Path  # of the table
    episodes: NDArray[np.int64]  # number of the episode, (rows,)
    frames: NDArray[np.int64]  # number of the frame in it, (rows,)
    times_s: NDArray[np.float64]  # since the episode's begin, (rows,)

    def rows_of(self, episode: int, length: int) -> NDArray[np.int64]:
        """Return the rows of an episode in order of its frames, (length,)."""
        rows = np.flatnonzero(self.episodes == episode)
        rows = rows[np.argsort(self.frames[rows], kind="stable")]
        if len(rows) != length:
            raise UnreadableClip(
                f"{self.path}: holds {len(rows)} rows of episode {episode}, expected {length}; "
                f"copy the data set again."
            )
        frames, times_s = self.frames[rows], self.times_s[rows]
        if not np.array_equal(frames, np.arange(length)):
            raise UnreadableClip(
                f"{self.path}: the frame_index of episode {episode} goes from {frames[0]} to "
                f"{frames[-1]} in {length} rows, expected each of 0 to {length - 1} once; copy or "
                f"record the data set again."
            )
        if not (np.diff(times_s) > 0).all():
            raise UnreadableClip(
                f"{self.path}: the timestamp of episode {episode} does not rise from frame to "
                f"frame, expected seconds since its begin; copy or record the data set again."
            )
        return rows


def read_frames(path: Path) -> FrameTable:
    """Return what the rows of a table are."""
    table = read_table(path, ["episode_index", "frame_index", "timestamp"])
    return FrameTable(
        path,
        column_of(path, table, "episode_index", is_whole=True),
        column_of(path, table, "frame_index", is_whole=True),
        column_of(path, table, "timestamp", is_whole=False),
    )


def read_table(path: Path, columns: Sequence[str] | None = None) -> pyarrow.Table:
    """Return a table, or some of its columns."""
    from pyarrow.parquet import ParquetFile

    # ParquetFile: read_table would look for columns in the names of the folders too.
    with damage_as_sentence(path), plain_name(path) as plain, ParquetFile(plain) as file:
        if file.metadata.num_rows > MOST_ROWS:
            raise UnreadableClip(
                f"{path}: holds {file.metadata.num_rows} rows, expected at most {MOST_ROWS}; write "
                f"the data set in several files."
            )
        table = file.read(columns=None if columns is None else list(columns))
    for name in columns or ():
        if table.column_names.count(name) != 1:
            raise UnreadableClip(
                f"{path}: has {table.column_names.count(name) or 'no'} column {name}, expected one "
                f"of a LeRobot data set (v3); convert or copy it again."
            )
    return table


@contextmanager
def damage_as_sentence(path: Path) -> Iterator[None]:
    """Turn what reading a table raises into one sentence; nothing is written in the block."""
    import pyarrow

    try:
        if not os.path.isfile(path):  # a pipe would be waited for
            raise FileNotFoundError("there is no such file")
        yield
    except (OSError, pyarrow.ArrowException, UnicodeDecodeError) as error:
        raise UnreadableClip(
            f"{path}: cannot be read ({first_line(error)}), expected a table of a LeRobot data "
            f"set; copy it again."
        ) from error


def column_of(
    path: Path, table: pyarrow.Table, name: str, *, is_whole: bool
) -> NDArray[np.int64] | NDArray[np.float64]:
    """Return a column of numbers that count, or of times in seconds, (rows,)."""
    from pyarrow import types

    column, most, expected = table[name], LONGEST_S, f"seconds from 0 to {LONGEST_S:g}"
    if is_whole:
        most, expected = 2**63, "whole numbers from 0 on"
    is_kind = types.is_integer(column.type) or (not is_whole and types.is_floating(column.type))
    if is_kind and not column.null_count:
        values = column.to_numpy()
        if ((values >= 0) & (values < most)).all():
            return values.astype(np.int64 if is_whole else np.float64)
    held = f"{column.null_count} empty cells" if column.null_count else f"{column.type} values"
    raise UnreadableClip(
        f"{path}: its column {name} holds {held} that cannot be, expected {expected}; copy or "
        f"record the data set again."
    )
