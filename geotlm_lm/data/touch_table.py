"""A table of recordings and of when each is touched; knows neither motions nor models.

A row names the recording in `clip`, its `fps`, and the first and last touched frame in
`contact_start` and `contact_end`, counted from 0; recordings never touched leave both empty.
`object` and `object_family` are read where there are such columns. `direction` names the main
motion of the whole recording, and `tier` how sure the table is of it; `rotation_start` and
`rotation_end` are the frames of its turn, `rotation_deg_cw` its size.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.data.labelled_recordings import csv_lines, object_of

TABLE_NAME = "clips.csv"

FIRST_IDLE = 1
"""A codec starts sharp: frame 0 is left out."""

BEFORE_TOUCH = 3
"""Frames before the labelled contact that are left out: the label was set by eye."""

SURELY_IDLE = 5
"""First frames taken as untouched beyond doubt: in some of the recordings seen, the gel changes by
up to 70 grey levels before the labelled contact."""

SURE_TIERS = ("A", "B", "")
"""Tiers whose direction counts as known: high and medium confidence, and tables without tiers."""

REQUIRED_COLUMNS = frozenset(("clip", "fps", "contact_start", "contact_end"))


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


@dataclass(frozen=True)
class DirectedRow:
    """A recording whose main motion has a known direction."""

    path: Path
    motion: Motion  # as displayed
    object_id: str
    object_family: str
    turn_deg: float | None = None  # its main turn, clockwise positive
    turning: tuple[int, int] | None = None  # first and last frame of that turn
    touched: tuple[int, int] | None = None  # first and last frame in contact


def read_touch_table(path: Path) -> list[TouchRow]:
    """Return the touched recordings of a table, none where there is no such file.

    Raises:
        UnreadableClip: If a column is missing or the frames of a row are out of order.
    """
    rows = []
    for recording, values in _rows(path):
        first, last = values["contact_start"], values["contact_end"]
        if not first:
            continue
        begins, ends = (int(text) if text.isdecimal() else -1 for text in (first, last))
        if not FIRST_IDLE < begins <= ends:
            raise UnreadableClip(
                f"{path}: {values['clip']} is touched from frame '{first}' to '{last}', expected "
                f"two numbers in order, the first above {FIRST_IDLE}: idle frames come before it."
            )
        about = object_of(recording, values)
        rows.append(TouchRow(recording, _fps(path, values), begins, ends, *about))
    return rows


def read_directed(path: Path) -> list[DirectedRow]:
    """Return the recordings whose main motion a table states, none where there is no such file."""
    return [
        DirectedRow(recording, Motion(word), *object_of(recording, values), *_turn(values))
        for recording, values in _rows(path)
        if (word := (values.get("direction") or "").strip().lower()) in DIRECTED
        and (values.get("tier") or "").strip() in SURE_TIERS
    ]


def _rows(path: Path) -> list[tuple[Path, dict[str, str]]]:
    if not path.is_file():
        return []
    columns, lines = csv_lines(path, "save it as CSV again")
    if not set(columns) >= REQUIRED_COLUMNS:
        raise UnreadableClip(
            f"{path}: found the columns {', '.join(map(str, columns))}, expected clip, fps, "
            f"contact_start and contact_end among them."
        )
    return [(path.parent / values["clip"], values) for _, values in lines]


def _turn(
    values: dict[str, str],
) -> tuple[float | None, tuple[int, int] | None, tuple[int, int] | None]:
    """Return the main turn, and the frames of it and of contact, as far as they are told."""
    turn = (values.get("rotation_deg_cw") or "").strip()

    def frames(first: str, last: str) -> tuple[int, int] | None:
        pair = [(values.get(name) or "").strip() for name in (first, last)]
        return tuple(map(int, pair)) if all(text.isdecimal() for text in pair) else None

    spans = frames("rotation_start", "rotation_end"), frames("contact_start", "contact_end")
    return float(turn) if turn else None, *spans


def _fps(path: Path, values: dict[str, str]) -> float:
    try:
        return float(values["fps"])
    except ValueError as error:
        raise UnreadableClip(
            f"{path}: {values['clip']} has '{values['fps']}' frames per second, expected a number."
        ) from error
