"""A table of recordings and of when each is touched; knows neither motions nor models.

A row names the recording in `clip`, its `fps`, and the first and last touched frame in
`contact_start` and `contact_end`, counted from 0; recordings never touched leave both empty.
`object` and `object_family` are read where there are such columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip
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


def _fps(path: Path, values: dict[str, str]) -> float:
    try:
        return float(values["fps"])
    except ValueError as error:
        raise UnreadableClip(
            f"{path}: {values['clip']} has '{values['fps']}' frames per second, expected a number."
        ) from error
