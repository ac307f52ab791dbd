"""How far whole recordings turn, measured by eye; knows neither motions nor models.

Beside the table of recordings (`touch_table`) stands `gold_turns.csv`: the net turn from
`first_frame` to `last_frame`, clockwise positive, and `half_width_deg`, within which who measured
was sure. Two more tables may tell its course: `gold_curves.csv` the turn since `first_frame` at
some frames, `gold_moments.csv` the frames at which half the turn and 30 degrees are passed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.data.labelled_recordings import csv_lines
from geotlm_lm.data.touch_table import TABLE_NAME, TouchRow, read_touch_table

TURNS, CURVES, MOMENTS = "gold_turns.csv", "gold_curves.csv", "gold_moments.csv"

COLUMNS = {
    TURNS: (
        *("clip", "first_frame", "last_frame", "turn_deg_cw", "half_width_deg"),
        *("quality", "turn_begin", "turn_end", "note"),
    ),
    CURVES: ("clip", "frame", "turn_deg_cw", "half_width_deg"),
    MOMENTS: ("clip", "half_turn_frame", "plus_minus", "frame_30deg", "plus_minus_30"),
}


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
    values: Mapping[str, str]

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
    lines = _lines(folder / TURNS)
    measured = {line.clip for line in lines}
    curves: dict[str, list[_Line]] = {}
    for line in _lines(folder / CURVES):
        curves.setdefault(_of_turn(line, measured), []).append(line)
    moments = {_of_turn(line, measured): line for line in _lines(folder / MOMENTS)}
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
            f"{line.where}: found the quality '{quality}', expected one of {', '.join(Quality)}; "
            f"correct it."
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


def _lines(path: Path) -> list[_Line]:
    if not path.is_file():
        return []
    columns, lines = csv_lines(path, "save it as CSV again")
    expected = COLUMNS[path.name]
    if not set(columns) >= set(expected):
        raise UnreadableClip(
            f"{path}: found the columns {', '.join(map(str, columns))}, expected "
            f"{', '.join(expected)} among them; add what is missing."
        )
    return [_Line(f"{path}:{number}", values) for number, values in lines]
