"""A data set beside the original: the same episodes with columns added; videos are linked."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm.core.atomic import replacing, write_text_atomically
from geotlm_lm.core.plain_name import plain_name
from geotlm_lm.data_sets.lerobot import EPISODES, INFO, STATISTICS, LeRobotDataSet
from geotlm_lm.data_sets.motion_columns import Values, features_of, statistics_of

if TYPE_CHECKING:
    import pyarrow

_EVENT_TYPES = {
    "episode_index": "int64",
    "event": "string",
    "way": "string",
    "begin": "int64",
    "end": "int64",
    "begin_s": "float64",
    "end_s": "float64",
    "amount": "float64",
    "low": "float64",
    "high": "float64",
    "unit": "string",
    "probability": "float64",
}


COPIED_BYTES = 2**20
"""Of a file at a time."""


@dataclass(frozen=True, eq=False)
class Labels:
    """What is added to a data set.

    Args:
        names: Of the columns.
        values: Of each episode, by its number, (frames, columns).
        events: As rows of the events' table, with their episode.
        events_file: Where that table goes, from the root on.
        made_by: Plain values that say what made them.
    """

    names: tuple[str, ...]
    values: Sequence[Values]
    events: Sequence[dict[str, Any]]
    events_file: str
    made_by: dict[str, Any]


def write_labelled(data_set: LeRobotDataSet, labels: Labels, out: Path) -> None:
    """Write the data set with what is added to it into a new folder.

    Args:
        data_set: The original, which is left as it is.
        labels: What is added.
        out: The folder; nothing may be in it.
    """
    rewritten = {data_set.data_path(one.row) for one in data_set.episodes}
    tables = {str(path.relative_to(data_set.root)) for path in _episode_tables(data_set)}
    _copy_others(data_set.root, out, rewritten | tables | {INFO, STATISTICS})
    info = data_set.info | {"features": data_set.features | features_of(labels.names)}
    write_text_atomically(out / INFO, json.dumps(info, indent=4) + "\n")
    for name in sorted(rewritten):
        _write_rows(data_set.root / name, out / name, labels)
    for name in sorted(tables):
        _write_episodes(data_set.root / name, out / name, labels)
    _write_statistics(data_set.root / STATISTICS, out / STATISTICS, labels)
    _write_events(out / labels.events_file, labels)


def _episode_tables(data_set: LeRobotDataSet) -> list[Path]:
    return sorted((data_set.root / EPISODES).glob("*/*.parquet"))


def _copy_others(root: Path, out: Path, but: set[str]) -> None:
    """Link videos and copy every other file; what is hidden, such as a cache, stays behind."""
    for path in sorted(root.rglob("*")):
        name = path.relative_to(root)
        if str(name) in but or not path.is_file() or any(one[0] == "." for one in name.parts):
            continue
        source = path.resolve()  # a downloaded set's files are links into a cache
        if path.suffix == ".mp4":
            try:
                (out / name).parent.mkdir(parents=True, exist_ok=True)
                os.link(source, out / name)
                continue
            except OSError:  # on another disk, or where links are not possible
                pass
        with source.open("rb") as original, replacing(out / name) as copy:
            shutil.copyfileobj(original, copy, COPIED_BYTES)


def _write_rows(source: Path, target: Path, labels: Labels) -> None:
    """Write a table of frames with the columns, group of rows by group as it was."""
    import pyarrow
    from pyarrow import parquet

    with (
        plain_name(source) as plain,
        parquet.ParquetFile(plain) as file,
        replacing(target) as stream,
    ):
        added = [pyarrow.field(name, pyarrow.float32()) for name in labels.names]
        schema = pyarrow.schema([*file.schema_arrow, *added], file.schema_arrow.metadata)
        with parquet.ParquetWriter(stream, schema) as writer:
            for group in range(file.num_row_groups):
                table = file.read_row_group(group)
                for number, name in enumerate(labels.names):
                    column = _of_rows(table, labels.values, number)
                    table = table.append_column(name, pyarrow.array(column))
                writer.write_table(table.cast(schema))


def _of_rows(table: pyarrow.Table, values: Sequence[Values], number: int) -> Values:
    episodes = table["episode_index"].to_numpy()
    frames = table["frame_index"].to_numpy()
    column = np.empty(len(frames), np.float32)
    for episode in np.unique(episodes):
        where = episodes == episode
        column[where] = values[episode][frames[where], number]
    return column


def _write_episodes(source: Path, target: Path, labels: Labels) -> None:
    """Write a table of episodes with the columns' statistics, where it holds others'."""
    import pyarrow
    from pyarrow import parquet

    with plain_name(source) as plain, parquet.ParquetFile(plain) as file:
        table = file.read()
    if any(name.startswith("stats/") for name in table.column_names):
        episodes = table["episode_index"].to_pylist()
        for number, name in enumerate(labels.names):
            told = [statistics_of(labels.values[one][:, number]) for one in episodes]
            for kind in told[0]:
                whole = pyarrow.int64() if kind == "count" else pyarrow.float64()
                cells = pyarrow.array([one[kind] for one in told], pyarrow.list_(whole))
                table = table.append_column(f"stats/{name}/{kind}", cells)
    with replacing(target) as stream:
        parquet.write_table(table, stream)


def _write_statistics(source: Path, target: Path, labels: Labels) -> None:
    if not source.is_file():  # none are kept of the other columns either
        return
    statistics = json.loads(source.read_text(encoding="utf-8"))
    for number, name in enumerate(labels.names):
        statistics[name] = statistics_of(np.concatenate([one[:, number] for one in labels.values]))
    write_text_atomically(target, json.dumps(statistics, indent=4) + "\n")


def _write_events(path: Path, labels: Labels) -> None:
    import pyarrow
    from pyarrow import parquet

    fields = [
        pyarrow.field(name, pyarrow.type_for_alias(kind)) for name, kind in _EVENT_TYPES.items()
    ]
    about = {"geotlm_lm": json.dumps(labels.made_by)}
    table = pyarrow.Table.from_pylist(list(labels.events), pyarrow.schema(fields, about))
    with replacing(path) as stream:
        parquet.write_table(table, stream)
