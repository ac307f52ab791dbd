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
    """One row of a table: where a motion stands in a recording.

    Args:
        path: The recording.
        first_frame: First frame of the window, counted from 0.
        last_frame: Last frame of the window, included.
        motion: The motion, as displayed.
        object_id: What is touched; the file's name without its ending when the table is silent.
        object_family: Objects that belong together when clips are split; else `object_id`.
        values: The row as it stands in the table.
    """

    path: Path
    first_frame: int
    last_frame: int
    motion: Motion
    object_id: str
    object_family: str
    values: dict[str, str]


@dataclass(frozen=True, eq=False)
class LabelledWindow:
    """One clip with its label.

    Args:
        clip: Four frames, with the idle gel as its background.
        motion: The label, already reversed where the clip is played backwards.
        frames: How the frames were chosen: "four" evenly, or "pair", shown as a, a, b, b.
        is_backwards: Whether the clip is played backwards.
        row: The row the clip comes from.
    """

    clip: Clip
    motion: Motion
    frames: FrameChoice
    is_backwards: bool
    row: WindowRow

    @property
    def object_id(self) -> str:
        """What is touched."""
        return self.row.object_id


@dataclass(frozen=True, eq=False)
class LabelledRecordings:
    """The labelled windows of one folder.

    Args:
        folder: The folder that holds the table.
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
            frames: Which choices of frames to cut from each window.
            backwards: Whether each window is also played backwards, with the reversed label.

        Raises:
            UnreadableClip: If a recording cannot be read or is shorter than a row says.
            UsageError: If `frames` names an unknown choice.
        """
        unknown = set(frames) - {"four", "pair"}
        if unknown or not frames:
            raise UsageError(f"frames: found {sorted(unknown) or 'none'}, expected four or pair.")
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
    inside = [own] if own else [_read_folder(one) for one in sorted(folder.iterdir())]
    found = [one for one in inside if one is not None]
    if not found:
        raise UnreadableClip(
            f"{folder}: found no CSV table with the columns clip, first_frame, last_frame and "
            f"direction, separated by commas, neither here nor in the folders inside; write one "
            f"row per motion."
        )
    return found


def choose_window(recording: Clip, row: WindowRow, frames: FrameChoice) -> Clip:
    """Return the four frames that stand for a window.

    Args:
        recording: The whole recording.
        row: The window.
        frames: "four": evenly from the first to the last; "pair": the first frame and the one
            `PAIR_DISTANCE` later (or the window's last), each twice.

    Raises:
        UnreadableClip: If the recording ends before the window does.
    """
    if row.last_frame >= len(recording):
        raise UnreadableClip(
            f"{row.path}: the table names frame {row.last_frame}, the recording holds frames 0 to "
            f"{len(recording) - 1}; correct last_frame."
        )
    if frames == "pair":
        late = min(row.first_frame + PAIR_DISTANCE, row.last_frame)
        numbers = [row.first_frame, row.first_frame, late, late]
    else:
        numbers = np.linspace(row.first_frame, row.last_frame, FRAME_COUNT).round().astype(int)
    clip = recording.select([int(number) for number in numbers])
    return replace(clip, name=f"{row.path.name}[{row.first_frame}:{row.last_frame}]")


def _cut(
    recording: Clip, row: WindowRow, frames: Sequence[FrameChoice], backwards: bool
) -> Iterator[LabelledWindow]:
    for choice in frames:
        clip = choose_window(recording, row, choice)
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
    if not folder.is_dir():
        return None
    rows: list[WindowRow] = []
    skipped: Counter[str] = Counter()
    is_labelled = False
    for table in sorted(folder.glob("*.csv")):
        # A letter in another encoding then spoils its own row, which is named, not the whole table.
        with table.open(newline="", encoding="utf-8-sig", errors="replace") as stream:
            reader = csv.DictReader(stream)
            try:
                is_labelled |= _read_table(folder, table, reader, rows, skipped)
            except csv.Error as error:
                raise UnreadableClip(
                    f"{table}: is no table ({error} in line {reader.line_num}); save it as CSV "
                    f"again, or take it away."
                ) from error
    return LabelledRecordings(folder, tuple(rows), skipped) if is_labelled else None


def _read_table(
    folder: Path,
    table: Path,
    reader: csv.DictReader,
    rows: list[WindowRow],
    skipped: Counter[str],
) -> bool:
    """Add a table's windows to `rows`; return whether it is a table of windows at all."""
    columns = reader.fieldnames or ()
    direction = next((name for name in DIRECTION_COLUMNS if name in columns), None)
    if direction is None or any(name not in columns for name in REQUIRED_COLUMNS):
        return False
    for values in reader:
        word = (values[direction] or "").strip().lower()
        motion = _motion_of(word)
        if motion is None:
            skipped[word or "(empty)"] += 1
        else:
            rows.append(_read_row(folder, f"{table}:{reader.line_num}", values, motion))
    return True


def _motion_of(word: str) -> Motion | None:
    if word in OTHER_WORDS:
        return OTHER_WORDS[word]
    return Motion(word) if word in set(Motion) else None


def _read_row(folder: Path, where: str, values: dict[str, str], motion: Motion) -> WindowRow:
    name = (values["clip"] or "").strip()
    path = next((p for p in (folder / name, folder / "clips" / name) if p.exists()), None)
    if not name or path is None:
        raise UnreadableClip(
            f"{where}: the recording '{name}' is missing; expected it below {folder}."
        )
    try:
        first, last = int(values["first_frame"]), int(values["last_frame"])
    except (TypeError, ValueError):
        first, last = 0, 0
    if not 0 <= first < last:
        raise UsageError(
            f"{where}: found first_frame {values['first_frame']!r} and last_frame "
            f"{values['last_frame']!r}, expected whole numbers from 0, the first below the last."
        )
    object_id = (values.get("object") or "").strip() or path.stem
    family = (values.get("object_family") or "").strip() or object_id
    return WindowRow(path, first, last, motion, object_id, family, dict(values))
