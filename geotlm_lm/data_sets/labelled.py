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
from numpy.typing import NDArray

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.files import plain_name, replacing, write_text_atomically
from geotlm_lm.data_sets.layout import (
    EPISODES,
    INFO,
    STATISTICS,
    contained,
    damage_as_sentence,
    read_frames,
    read_object,
    read_table,
)
from geotlm_lm.data_sets.lerobot import Episode, LeRobotDataSet

if TYPE_CHECKING:
    import pyarrow

Values = NDArray[np.float32]

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

QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)
"""That LeRobot keeps of a column."""

COPIED_BYTES = 2**20
"""Of a file at a time."""


@dataclass(frozen=True, eq=False)
class Labels:
    """What is added to a data set."""

    names: tuple[str, ...]  # of the columns
    values: Sequence[Values]  # of each episode, by its number, (frames, columns)
    events: Sequence[dict[str, Any]]  # as rows of the events' table, with their episode
    events_file: str  # where that table goes, from the root on
    made_by: dict[str, Any]  # plain values that say what made them


def require_whole(data_set: LeRobotDataSet) -> None:
    """Refuse a data set of which no labelled copy can be written.

    Raises:
        UnreadableClip: If a table of frames is missing, damaged, or not what the episodes say, if
            the statistics are damaged, or if a folder is a link, which is not followed.
    """
    episodes: dict[str, list[Episode]] = {}
    for episode in data_set.episodes:
        episodes.setdefault(data_set.data_path(episode), []).append(episode)
    for name, held in episodes.items():
        table = read_frames(contained(data_set.root, name))
        for episode in held:
            table.rows_of(episode.index, episode.length)
        others = np.setdiff1d(table.episodes, [episode.index for episode in held])
        if len(others):
            raise UnreadableClip(
                f"{table.path}: holds rows of episode {others[0]}, expected those of the episodes "
                f"that {EPISODES} places there; copy or record the data set again."
            )
    _read_statistics(data_set)
    _other_files(data_set.root, set())


def write_labelled(data_set: LeRobotDataSet, labels: Labels, out: Path) -> None:
    """Write the data set with what is added to it into a new folder, in which nothing may be."""
    rewritten = {data_set.data_path(episode) for episode in data_set.episodes}
    tables = {
        path.relative_to(data_set.root).as_posix()
        for path in sorted((data_set.root / EPISODES).glob("*/*.parquet"))
    }
    _copy_others(data_set.root, out, rewritten | tables | {INFO, STATISTICS})
    added = {name: {"dtype": "float32", "shape": [1], "names": None} for name in labels.names}
    features = data_set.features | added
    info = data_set.info.content | {"features": features}
    write_text_atomically(out / INFO, json.dumps(info, indent=4) + "\n")
    for name in sorted(rewritten):
        _write_rows(data_set.root / name, out / name, labels)
    for name in sorted(tables):
        _write_episodes(data_set.root / name, out / name, labels)
    _write_statistics(data_set, out / STATISTICS, labels)
    _write_events(out / labels.events_file, labels)


def _other_files(root: Path, but: set[str]) -> list[Path]:
    """Return the files of a folder but some; what is hidden, such as a cache, is passed over."""
    files = []
    for folder, names, file_names in os.walk(root):
        here = Path(folder)
        names[:] = sorted(name for name in names if not name.startswith("."))
        link = next((name for name in names if os.path.islink(here / name)), None)
        if link is not None:
            raise UnreadableClip(
                f"{here / link}: is a link to a folder, which would be missing beside the labels, "
                f"expected the folder itself; copy the data set with the files that links lead to."
            )
        paths = [here / name for name in sorted(file_names) if not name.startswith(".")]
        files += [path for path in paths if os.path.isfile(path)]
    return [path for path in files if path.relative_to(root).as_posix() not in but]


def _copy_others(root: Path, out: Path, but: set[str]) -> None:
    """Link videos and copy every other file."""
    for path in _other_files(root, but):
        name = path.relative_to(root)
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


def _statistics_of(values: Values) -> dict[str, list[float | int]]:
    """Return the statistics of a column, (n,), as LeRobot keeps them; NaN does not count."""
    known = values[np.isfinite(values)].astype(np.float64)
    known = known if len(known) else np.zeros(1)
    kinds = {"min": known.min(), "max": known.max(), "mean": known.mean(), "std": known.std()}
    quantiles = np.quantile(known, QUANTILES)
    kinds |= {f"q{round(100 * q):02d}": x for q, x in zip(QUANTILES, quantiles, strict=True)}
    return {name: [float(value)] for name, value in kinds.items()} | {"count": [len(values)]}


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
                with damage_as_sentence(source):
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

    table = read_table(source)
    if any(name.startswith("stats/") for name in table.column_names):
        episodes = table["episode_index"].to_pylist()
        for number, name in enumerate(labels.names):
            known = [_statistics_of(labels.values[index][:, number]) for index in episodes]
            for kind in _statistics_of(np.zeros(1, np.float32)):  # of no episode, too
                whole = pyarrow.int64() if kind == "count" else pyarrow.float64()
                cells = pyarrow.array([column[kind] for column in known], pyarrow.list_(whole))
                table = table.append_column(f"stats/{name}/{kind}", cells)
    with replacing(target) as stream:
        parquet.write_table(table, stream)


def _read_statistics(data_set: LeRobotDataSet) -> dict[str, Any] | None:
    path = data_set.root / STATISTICS
    return read_object(path) if os.path.lexists(path) else None


def _write_statistics(data_set: LeRobotDataSet, target: Path, labels: Labels) -> None:
    statistics = _read_statistics(data_set)
    if statistics is None:  # none are kept of the other columns either
        return
    for number, name in enumerate(labels.names):
        column = np.concatenate([values[:, number] for values in labels.values])
        statistics[name] = _statistics_of(column)
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
