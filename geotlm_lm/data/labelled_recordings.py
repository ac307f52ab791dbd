"""Labelled windows of real recordings: a folder of clips and a table of who moves when.

Knows files, frame numbers and directions; nothing of models. A folder is laid out as

    clips/bottle_cap_0.mov, clips/...      anything `read_clip` reads
    windows.csv                            any name; columns clip, first_frame, last_frame,
                                           direction, and if known object, object_family, ...

or holds several such folders. Frame numbers count from 0 and both ends belong to the window.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.recordings.idle import estimate_background, find_idle
from geotlm_lm.recordings.read import read_clip

FrameChoice = Literal["four", "pair"]

REQUIRED_COLUMNS = ("clip", "first_frame", "last_frame")

DIRECTION_COLUMNS = ("direction", "label")
"""Names under which published tables give the motion."""

OTHER_WORDS = {
    "cw": Motion.CLOCKWISE,
    "ccw": Motion.COUNTERCLOCKWISE,
    "counter-clockwise": Motion.COUNTERCLOCKWISE,
    "anticlockwise": Motion.COUNTERCLOCKWISE,
    "anti-clockwise": Motion.COUNTERCLOCKWISE,
    "no contact": Motion.NONE,
}
"""Directions people write that are not the values of `Motion`."""

SETTLING_FRAMES = 16
"""First frames that a guessed background leaves out of a long recording: some cameras begin with
pictures of an earlier recording and settle their exposure (seen in gripper recordings)."""

SETTLED_SHARE = 10
"""How many times longer a recording must be for that; the start of a short one may be the only part
that is untouched."""

PAIR_DISTANCE = 2
"""Frames between the two of a pair: about 2.4 degrees of a hand-held turn at 25 fps."""


@dataclass(frozen=True)
class WindowRow:
    """One row of a table: where a motion stands in a recording."""

    path: Path  # the recording
    first_frame: int  # counted from 0
    last_frame: int  # included
    motion: Motion  # as displayed
    object_id: str  # what is touched; the file's name without its ending when the table is silent
    object_family: str  # objects that belong together when clips are split; else `object_id`
    values: dict[str, str]  # the row as it stands in the table


@dataclass(frozen=True, eq=False)
class LabelledWindow:
    """One clip with its label."""

    clip: Clip  # four frames, with the idle gel as its background
    motion: Motion  # the label, already reversed where the clip is played backwards
    frames: FrameChoice  # how the frames were chosen: "four" evenly, or "pair", shown as a, a, b, b
    is_backwards: bool  # whether the clip is played backwards
    row: WindowRow  # the row the clip comes from


@dataclass(frozen=True, eq=False)
class LabelledRecordings:
    """The labelled windows of one folder.

    Args:
        folder: Holds the tables.
        rows: Usable rows, in the order of the tables.
        skipped: How many rows were left out, by the word that stands for their direction.
    """

    folder: Path
    rows: tuple[WindowRow, ...]
    skipped: Counter[str] = field(default_factory=Counter)

    def windows(
        self, *, frames: Sequence[FrameChoice] = ("four",), backwards: bool = True
    ) -> Iterator[LabelledWindow]:
        """Cut the windows, decoding each recording once.

        Args:
            frames: Which frames to cut from each window: "four" evenly from the first to the last;
                "pair": the first and the one `PAIR_DISTANCE` later (or the last), each twice.
            backwards: Whether each window is also played backwards, with the reversed label.

        Raises:
            UnreadableClip: If a recording cannot be read or is shorter than a row says.
        """
        by_path: dict[Path, list[WindowRow]] = {}
        for row in self.rows:
            by_path.setdefault(row.path, []).append(row)
        for path, rows in by_path.items():
            recording = _with_background(read_clip(path))
            for row in rows:
                yield from _cut(recording, row, frames, backwards)


def find_labelled_recordings(folder: str | Path) -> list[LabelledRecordings]:
    """Read the tables of `folder`, or else those of the folders inside it.

    Raises:
        UnreadableClip: If the folder is missing, holds no such table, or a recording is missing.
        UsageError: If a row has no usable frame numbers.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise UnreadableClip(
            f"{folder}: no such folder; expected recordings and a CSV table of labelled windows."
        )
    own = _read_folder(folder)
    folders = [inside for inside in sorted(folder.iterdir()) if inside.is_dir()]
    inside = [own] if own else map(_read_folder, folders)
    labelled = [recordings for recordings in inside if recordings is not None]
    if not labelled:
        raise UnreadableClip(
            f"{folder}: found no CSV table with the columns clip, first_frame, last_frame and "
            f"direction, separated by commas, neither here nor in the folders inside; write one "
            f"row per motion."
        )
    return labelled


def _cut(
    recording: Clip, row: WindowRow, frames: Sequence[FrameChoice], backwards: bool
) -> Iterator[LabelledWindow]:
    first, last = row.first_frame, row.last_frame
    if last >= len(recording):
        raise UnreadableClip(
            f"{row.path}: the table names frame {last}, the recording holds frames 0 to "
            f"{len(recording) - 1}; correct last_frame."
        )
    for choice in frames:
        if choice == "pair":
            late = min(first + PAIR_DISTANCE, last)
            numbers = [first, first, late, late]
        else:
            numbers = np.linspace(first, last, FRAME_COUNT).round().astype(int).tolist()
        clip = replace(recording.select(numbers), name=f"{row.path.name}[{first}:{last}]")
        yield LabelledWindow(clip, row.motion, choice, False, row)
        if backwards:
            yield LabelledWindow(clip.reversed(), opposite(row.motion), choice, True, row)


def _with_background(recording: Clip) -> Clip:
    if recording.background is not None:
        return recording
    idle = find_idle(recording)
    if idle is not None:
        return replace(recording, background=idle)
    settled = recording.frames
    if len(settled) >= SETTLED_SHARE * SETTLING_FRAMES:
        settled = settled[SETTLING_FRAMES:]
    guess = estimate_background(settled)
    return replace(recording, background=guess).with_note(
        "no idle frames at either end: the background is guessed from the shading"
    )


def _read_folder(folder: Path) -> LabelledRecordings | None:
    """Return the windows of a folder's tables; None where no table is one of windows."""
    rows: list[WindowRow] = []
    skipped: Counter[str] = Counter()
    is_labelled = False
    for table in sorted(folder.glob("*.csv")):
        columns, lines = csv_lines(table, "save it as CSV again, or take it away")
        direction = next((name for name in DIRECTION_COLUMNS if name in columns), None)
        if direction is None or any(name not in columns for name in REQUIRED_COLUMNS):
            continue
        is_labelled = True
        for line, values in lines:
            word = values[direction].strip().lower()
            motion = OTHER_WORDS.get(word) or (Motion(word) if word in set(Motion) else None)
            if motion is None:
                skipped[word or "(empty)"] += 1
            else:
                rows.append(_read_row(folder, f"{table}:{line}", values, motion))
    return LabelledRecordings(folder, tuple(rows), skipped) if is_labelled else None


def csv_lines(path: Path, advice: str) -> tuple[Sequence[str], list[tuple[int, dict[str, str]]]]:
    """Return the columns of a CSV table, and each row with its line; cells that lack are empty.

    Args:
        path: Of the table. A letter in another encoding spoils its own row, which is named.
        advice: What the user can do about a file that is none.

    Raises:
        UnreadableClip: If it is none.
    """
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as stream:
        reader = csv.DictReader(stream, restval="")
        try:
            lines = [(reader.line_num, values) for values in reader]
        except csv.Error as error:
            raise UnreadableClip(
                f"{path}: is no table ({error} in line {reader.line_num}); {advice}."
            ) from error
        return reader.fieldnames or (), lines


def _read_row(folder: Path, where: str, values: dict[str, str], motion: Motion) -> WindowRow:
    name = values["clip"].strip()
    path = next((p for p in (folder / name, folder / "clips" / name) if p.exists()), None)
    if not name or path is None:
        raise UnreadableClip(
            f"{where}: the recording '{name}' is missing; expected it below {folder}."
        )
    try:
        first, last = int(values["first_frame"]), int(values["last_frame"])
    except ValueError:
        first, last = 0, 0
    if not 0 <= first < last:
        raise UsageError(
            f"{where}: found first_frame {values['first_frame']!r} and last_frame "
            f"{values['last_frame']!r}, expected whole numbers from 0, the first below the last."
        )
    return WindowRow(path, first, last, motion, *object_of(path, values), dict(values))


def object_of(path: Path, values: dict[str, str]) -> tuple[str, str]:
    """Return what is touched, after the file where the table is silent, and its family."""
    object_id = (values.get("object") or "").strip() or path.stem
    return object_id, (values.get("object_family") or "").strip() or object_id
