"""Tables of a LeRobot data set, their columns checked as they are read."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UnreadableClip, first_line
from geotlm_lm.core.files import plain_name

if TYPE_CHECKING:
    import pyarrow

MOST_ROWS = 50_000_000
"""Rows of a table that is read: 19 days of frames, 400 MB a column; a file of many more is small
where they are alike."""

LONGEST_S = 1e8
"""Seconds of a recording at most, 3 years: times beyond are damaged."""


@dataclass(frozen=True, eq=False)
class FrameTable:
    """Which frame of which episode each row of a table is.

    Args:
        path: Of the table.
        episodes: Number of the episode, (rows,).
        frames: Number of the frame in it, (rows,).
        times_s: Since the episode's begin, (rows,).
    """

    path: Path
    episodes: NDArray[np.int64]
    frames: NDArray[np.int64]
    times_s: NDArray[np.float64]

    def rows_of(self, episode: int, length: int) -> NDArray[np.int64]:
        """Return the rows of an episode in order of its frames, (length,).

        Raises:
            UnreadableClip: If these are not its frames from the first to the last, or their times
                do not rise.
        """
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
    """Return what the rows of a table are.

    Raises:
        UnreadableClip: If it cannot be read, or a column is missing or of another type.
    """
    table = read_table(path, ["episode_index", "frame_index", "timestamp"])
    return FrameTable(
        path,
        whole_numbers(path, table, "episode_index"),
        whole_numbers(path, table, "frame_index"),
        seconds(path, table, "timestamp"),
    )


def read_table(path: Path, columns: Sequence[str] | None = None) -> pyarrow.Table:
    """Return a table, or some of its columns.

    Raises:
        UnreadableClip: If it is missing, damaged, or lacks a column.
    """
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
    """Turn what reading a table raises into one sentence; nothing is written in the block.

    Raises:
        UnreadableClip: If the table is missing or damaged.
    """
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


def whole_numbers(path: Path, table: pyarrow.Table, name: str) -> NDArray[np.int64]:
    """Return a column of numbers that count, (rows,).

    Raises:
        UnreadableClip: If it holds something else.
    """
    from pyarrow import types

    column = table[name]
    if types.is_integer(column.type) and not column.null_count:
        values = column.to_numpy()
        if len(values) == 0 or (values.min() >= 0 and values.max() < 2**63):
            return values.astype(np.int64)
    raise _wrong_column(path, table, name, "whole numbers from 0 on")


def seconds(path: Path, table: pyarrow.Table, name: str) -> NDArray[np.float64]:
    """Return a column of times, (rows,).

    Raises:
        UnreadableClip: If it holds something else.
    """
    from pyarrow import types

    column = table[name]
    is_number = types.is_floating(column.type) or types.is_integer(column.type)
    if is_number and not column.null_count:
        values = column.to_numpy().astype(np.float64)
        if ((values >= 0) & (values < LONGEST_S)).all():
            return values
    raise _wrong_column(path, table, name, f"seconds from 0 to {LONGEST_S:g}")


def _wrong_column(path: Path, table: pyarrow.Table, name: str, expected: str) -> UnreadableClip:
    column = table[name]
    held = f"{column.null_count} empty cells" if column.null_count else f"{column.type} values"
    return UnreadableClip(
        f"{path}: its column {name} holds {held} that cannot be, expected {expected}; copy or "
        f"record the data set again."
    )
