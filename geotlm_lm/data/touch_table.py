"""A table of recordings and of when each is touched; knows neither motions nor models.

A row names the recording in `clip`, its `fps`, and the first and last touched frame in
`contact_start` and `contact_end`, counted from 0; recordings never touched leave both empty.
`object` and `object_family` are read where there are such columns.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip

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
    """A recording in which something touches.

    Args:
        path: The recording.
        fps: Frames per second.
        contact_start: First touched frame.
        contact_end: Last touched frame.
        object_id: What touches; the file's name without its ending when the table is silent.
        object_family: Objects that belong together; else `object_id`.
    """

    path: Path
    fps: float
    contact_start: int
    contact_end: int
    object_id: str
    object_family: str

    @property
    def idle(self) -> range:
        """Numbers of the frames before the labelled contact."""
        return range(FIRST_IDLE, max(self.contact_start - BEFORE_TOUCH, FIRST_IDLE + 1))

    @property
    def surely_idle(self) -> range:
        """Numbers of the first idle frames, long before anything touches."""
        return self.idle[:SURELY_IDLE]

    def check_length(self, frames: int) -> None:
        """Refuse a recording that ends before the touch does.

        Raises:
            UnreadableClip: If `frames` is too small a number.
        """
        if self.contact_end >= frames:
            raise UnreadableClip(
                f"{self.path}: the table names frame {self.contact_end}, the recording holds "
                f"frames 0 to {frames - 1}; correct contact_end."
            )


def read_touch_table(path: str | Path) -> list[TouchRow]:
    """Return the touched recordings of a table, none where there is no such file.

    Raises:
        UnreadableClip: If a column is missing or the frames of a row are out of order.
    """
    path = Path(path)
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as stream:
        reader = csv.DictReader(stream)
        try:
            rows, columns = list(reader), reader.fieldnames or ()
        except csv.Error as error:
            raise UnreadableClip(
                f"{path}: is no table ({error} in line {reader.line_num}); save it as CSV again."
            ) from error
    if not set(columns) >= REQUIRED_COLUMNS:
        raise UnreadableClip(
            f"{path}: found the columns {', '.join(map(str, columns))}, expected clip, fps, "
            f"contact_start and contact_end among them."
        )
    return [_row(path, values) for values in rows if values["contact_start"]]


def _row(path: Path, values: dict[str, str]) -> TouchRow:
    first, last = values["contact_start"], values["contact_end"] or ""
    begins, ends = (int(text) if text.isdecimal() else -1 for text in (first, last))
    if not FIRST_IDLE < begins <= ends:
        raise UnreadableClip(
            f"{path}: {values['clip']} is touched from frame '{first}' to '{last}', expected two "
            f"numbers in order, the first above {FIRST_IDLE}: idle frames come before it."
        )
    recording = path.parent / values["clip"]
    object_id = (values.get("object") or "").strip() or recording.stem
    family = (values.get("object_family") or "").strip() or object_id
    try:
        fps = float(values["fps"])
    except ValueError as error:
        raise UnreadableClip(
            f"{path}: {values['clip']} has '{values['fps']}' frames per second, expected a number."
        ) from error
    return TouchRow(recording, fps, begins, ends, object_id, family)
