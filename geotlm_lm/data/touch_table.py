"""Tables of recordings: when each is touched, and how far some turn; knows no motions, no models.

A row of `clips.csv` names the recording in `clip`, its `fps`, and the first and last touched frame
in `contact_start` and `contact_end`, counted from 0; recordings never touched leave both empty.
`object` and `object_family` are read where there are such columns.

Beside it may stand `gold_turns.csv`, measured by eye: the net turn from `first_frame` to
`last_frame`, clockwise positive, and `half_width_deg`, within which who measured was sure. Two more
tables may tell its course: `gold_curves.csv` the turn since `first_frame` at some frames,
`gold_moments.csv` the frames at which half the turn and 30 degrees are passed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip, choice_of
from geotlm_lm.data.labelled_recordings import csv_lines, object_of

TABLE_NAME = "clips.csv"

FIRST_IDLE = 1
"""A codec starts sharp: frame 0 is left out."""

BEFORE_TOUCH = 3
"""Frames before the labelled contact that are left out: the label was set by eye."""

SURELY_IDLE = 5
"""First frames taken as untouched beyond doubt: in some of the recordings seen, the gel changes by
up to 70 grey levels before the labelled contact."""

REQUIRED_COLUMNS = frozenset(("clip", "fps", "contact_start", "contact_end"))

TURNS, CURVES, MOMENTS = "gold_turns.csv", "gold_curves.csv", "gold_moments.csv"

COLUMNS = {
    TURNS: (
        *("clip", "first_frame", "last_frame", "turn_deg_cw", "half_width_deg"),
        *("quality", "turn_begin", "turn_end", "note"),
    ),
    CURVES: ("clip", "frame", "turn_deg_cw", "half_width_deg"),
    MOMENTS: ("clip", "half_turn_frame", "plus_minus", "frame_30deg", "plus_minus_30"),
}


@dataclass(frozen=True)
class TouchRow:
    """A recording in which something touches."""

    path: Path
    fps: float
    contact_start: int  # first touched frame
    contact_end: int  # last touched frame
    object_id: str  # the file's name without its ending when the table is silent
    object_family: str  # else `object_id`

    @property
    def idle(self) -> range:
        """Numbers of the frames before the labelled contact."""
        return range(FIRST_IDLE, max(self.contact_start - BEFORE_TOUCH, FIRST_IDLE + 1))

    @property
    def surely_idle(self) -> range:
        """Numbers of the first idle frames, long before anything touches."""
        return self.idle[:SURELY_IDLE]

    def check_length(self, frames: int) -> None:
        """Refuse a recording that ends before the touch does."""
        if self.contact_end >= frames:
            raise UnreadableClip(
                f"{self.path}: the table names frame {self.contact_end}, the recording holds "
                f"frames 0 to {frames - 1}; correct contact_end."
            )


def read_touch_table(path: Path) -> list[TouchRow]:
    """Return the touched recordings of a table, none where there is no such file.

    Raises:
        UnreadableClip: If a column is missing or the frames of a row are out of order.
    """
    rows = []
    wanted = "clip, fps, contact_start and contact_end among them."
    for line in _lines(path, REQUIRED_COLUMNS, wanted):
        values, recording = line.values, path.parent / line.values["clip"]
        first, last = values["contact_start"], values["contact_end"]
        if not first:
            continue
        begins, ends = (int(text) if text.isdecimal() else -1 for text in (first, last))
        if not FIRST_IDLE < begins <= ends:
            raise UnreadableClip(
                f"{path}: {values['clip']} is touched from frame '{first}' to '{last}', expected "
                f"two numbers in order, the first above {FIRST_IDLE}: idle frames come before it."
            )
        try:
            fps = float(values["fps"])
        except ValueError as error:
            raise UnreadableClip(
                f"{path}: {values['clip']} has '{values['fps']}' frames per second, expected a "
                f"number."
            ) from error
        rows.append(TouchRow(recording, fps, begins, ends, *object_of(recording, values)))
    return rows


class Quality(StrEnum):
    """How well a turn could be measured."""

    SURE = "sure"
    FAIR = "fair"
    """Its half-width counts for the tolerance it is graded by."""
    POOR = "poor"
    """Nothing is graded by it."""


@dataclass(frozen=True)
class CurvePoint:
    """How far it has turned since the first labelled frame."""

    frame: int
    turn_deg: float  # clockwise positive
    half_width_deg: float


@dataclass(frozen=True)
class Moment:
    """When something is passed, in frames, and how far off that may be."""

    frame: float
    half_width: float


@dataclass(frozen=True)
class GoldTurn:
    """The turn of a recording between two of its frames."""

    recording: TouchRow
    first_frame: int
    last_frame: int  # included
    turn_deg: float  # clockwise positive, not 0
    half_width_deg: float
    quality: Quality
    turning: tuple[int, int]  # first and last frame of the turn itself
    note: str
    curve: tuple[CurvePoint, ...] = ()
    half_turn: Moment | None = None
    past_30_deg: Moment | None = None  # of either way

    @property
    def object_family(self) -> str:
        """Objects that belong together when recordings are split."""
        return self.recording.object_family

    @property
    def slack_deg(self) -> float:
        """What is added to the tolerance it is graded by."""
        return self.half_width_deg if self.quality is Quality.FAIR else 0.0


@dataclass(frozen=True)
class _Line:
    where: str
    values: dict[str, str]

    @property
    def clip(self) -> str:
        return self.values["clip"].strip()

    def number(self, name: str, least: float = -math.inf) -> float:
        text = self.values[name].strip()
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not least <= number < math.inf:
            above = "" if least == -math.inf else f" of {least:g} or more"
            raise UnreadableClip(
                f"{self.where}: found '{text}' as {name}, expected a number{above}; correct it."
            )
        return number

    def frames(self, first: str, last: str) -> tuple[int, int]:
        texts = [self.values[name].strip() for name in (first, last)]
        begin, end = (int(text) if text.isdecimal() else -1 for text in texts)
        if not 0 <= begin < end:
            raise UnreadableClip(
                f"{self.where}: found '{texts[0]}' as {first} and '{texts[1]}' as {last}, expected "
                f"whole numbers from 0, the first below the last; correct them."
            )
        return begin, end

    def moment(self, frame: str, half_width: str) -> Moment | None:
        if not self.values[frame].strip():
            return None
        return Moment(self.number(frame, 0), self.number(half_width, 0))


def read_gold_turns(folder: Path) -> list[GoldTurn]:
    """Return the measured turns of a folder of recordings, none where there is no such table.

    Raises:
        UnreadableClip: If a table lacks a column, a value is none, or the tables do not agree.
    """
    touched = {row.path: row for row in read_touch_table(folder / TABLE_NAME)}
    lines = _gold_lines(folder / TURNS)
    measured = {line.clip for line in lines}
    curves: dict[str, list[_Line]] = {}
    for line in _gold_lines(folder / CURVES):
        curves.setdefault(_of_turn(line, measured), []).append(line)
    moments = {_of_turn(line, measured): line for line in _gold_lines(folder / MOMENTS)}
    turns = []
    for line in lines:
        recording = touched.get(folder / line.clip)
        if recording is None:
            raise UnreadableClip(
                f"{line.where}: found '{line.clip}', expected a touched recording of {TABLE_NAME}; "
                f"write its contact_start and contact_end there."
            )
        turns.append(_turn(line, recording, curves.get(line.clip, []), moments.get(line.clip)))
    return turns


def _turn(line: _Line, recording: TouchRow, curve: list[_Line], moments: _Line | None) -> GoldTurn:
    frames, quality = line.frames("first_frame", "last_frame"), line.values["quality"].strip()
    if quality not in set(Quality):
        raise UnreadableClip(
            f"{line.where}: found the quality '{quality}'; {choice_of(quality, Quality)}"
        )
    turn_deg = line.number("turn_deg_cw")
    if turn_deg == 0:
        raise UnreadableClip(
            f"{line.where}: found a turn of 0 degrees, expected one way; take the row away."
        )
    return GoldTurn(
        recording,
        *frames,
        turn_deg,
        line.number("half_width_deg", 0),
        Quality(quality),
        line.frames("turn_begin", "turn_end"),
        line.values["note"],
        tuple(_point(point, *frames) for point in curve),
        moments and moments.moment("half_turn_frame", "plus_minus"),
        moments and moments.moment("frame_30deg", "plus_minus_30"),
    )


def _point(line: _Line, first: int, last: int) -> CurvePoint:
    text = line.values["frame"].strip()
    if not text.isdecimal() or not first <= int(text) <= last:
        raise UnreadableClip(
            f"{line.where}: found '{text}' as frame, expected one of {first} to {last}, between "
            f"which {TURNS} tells the turn; correct it."
        )
    return CurvePoint(int(text), line.number("turn_deg_cw"), line.number("half_width_deg", 0))


def _of_turn(line: _Line, measured: set[str]) -> str:
    if line.clip not in measured:
        raise UnreadableClip(
            f"{line.where}: found '{line.clip}', expected a recording of {TURNS}; write it there."
        )
    return line.clip


def _gold_lines(path: Path) -> list[_Line]:
    expected = COLUMNS[path.name]
    return _lines(path, expected, f"{', '.join(expected)} among them; add what is missing.")


def _lines(path: Path, columns: Iterable[str], wanted: str) -> list[_Line]:
    """Return the rows of a table, none where there is no such file."""
    if not path.is_file():
        return []
    names, lines = csv_lines(path, "save it as CSV again")
    if not set(names) >= set(columns):
        raise UnreadableClip(
            f"{path}: found the columns {', '.join(map(str, names))}, expected {wanted}"
        )
    return [_Line(f"{path}:{number}", values) for number, values in lines]
