"""What `meta/info.json` of a LeRobot data set (v3) says, and the paths it names, kept inside."""

from __future__ import annotations

import json
import os
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from string import Formatter
from typing import Any

from geotlm_lm.core.clip import MOST_FPS
from geotlm_lm.core.errors import UnreadableClip, first_line

INFO, STATISTICS, EPISODES = "meta/info.json", "meta/stats.json", "meta/episodes"

VERSION, CONVERTED = "v3.", "v2.1"
"""What the version of a layout that is read begins with, and one that LeRobot converts to it."""

PLACE_FIELDS = ("chunk_index", "file_index")

USUAL_PATHS = {
    "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
}

_NUMBER_FORM = re.compile(r"0?[0-9]{0,2}d?")
"""How a number may be filled in: `03d`. A width of many digits would fill the memory."""


@dataclass(frozen=True)
class PathTemplate:
    """A path from the root on that stays below it, whatever numbers are filled in.

    Args:
        text: Names in braces stand for numbers, and for a camera.
    """

    text: str

    def filled(self, chunk: int, file: int, camera: str = "") -> str:
        """Return the path of a file, without `.` and doubled slashes."""
        numbers = dict(zip(PLACE_FIELDS, (chunk, file), strict=True))
        return str(PurePosixPath(self.text.format(video_key=camera, **numbers)))


@dataclass(frozen=True)
class Info:
    """What a data set says of itself.

    Args:
        fps: Frames per second, as a camera may have.
        kinds: The type of each column by its name; a camera's name is one part of a path.
        data_path: Of the tables of frames.
        video_path: Of the videos; None where no column is one.
        total_episodes: How many there are.
        content: All that the file holds.
    """

    fps: float
    kinds: Mapping[str, str]
    data_path: PathTemplate
    video_path: PathTemplate | None
    total_episodes: int
    content: dict[str, Any]


def read_info(root: Path) -> Info:
    """Return what the data set in a folder says of itself.

    Raises:
        UnreadableClip: If it is none, of another version, or says something that cannot be.
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
    has_videos = "video" in kinds.values()
    return Info(
        fps=float(fps),
        kinds=kinds,
        data_path=_template(path, content, "data_path", PLACE_FIELDS),
        video_path=_template(path, content, "video_path", (*PLACE_FIELDS, "video_key"))
        if has_videos
        else None,
        total_episodes=total,
        content=content,
    )


def read_object(path: Path) -> dict[str, Any]:
    """Return the JSON object in a file.

    Raises:
        UnreadableClip: If it cannot be read or holds something else.
    """
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

    Raises:
        UnreadableClip: If the folder that the file lies in is elsewhere.
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


def _kinds(path: Path, features: object) -> dict[str, str]:
    if not isinstance(features, dict):
        raise _senseless(path, "features", features, "an object with each column's dtype")
    kinds = {}
    for name, feature in features.items():
        kind = feature.get("dtype") if isinstance(feature, dict) else None
        if not isinstance(kind, str):
            raise _senseless(path, f"the dtype of {_shown(name)}", kind, "a text")
        if kind in ("video", "image") and not _is_part_of_a_path(name):
            raise _senseless(path, "a camera's name", name, "one without slashes")
        kinds[name] = kind
    return kinds


def _template(
    path: Path, content: dict[str, Any], name: str, fields: tuple[str, ...]
) -> PathTemplate:
    text = content.get(name)
    fault = _fault(text, fields) if isinstance(text, str) else "is no text"
    if fault is not None:
        raise UnreadableClip(
            f"{path}: its {name}, {_shown(text)}, {fault}, expected a path below the data set's "
            f"folder such as {USUAL_PATHS[name]}; correct it, or copy the data set again."
        )
    return PathTemplate(text)


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


def _is_part_of_a_path(name: str) -> bool:
    return name == PureWindowsPath(name).name and name != ".." and name.isprintable()


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
