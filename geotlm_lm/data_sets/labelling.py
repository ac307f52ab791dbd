"""Labels a whole LeRobot data set by tracking each of its episodes; a stopped run is continued.

The columns of each episode are kept in `NAME.part` beside the new data set until all are there, so
that a reader never sees half of it. Same bytes whatever the number of processes.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import zipfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import __version__
from geotlm_lm.answering.answerer import loaded
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.files import move_into_place, plain_name, replacing, write_text_atomically
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
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
from geotlm_lm.data_sets.lerobot import (
    Episode,
    LeRobotDataSet,
    episode_clip,
    episode_frames,
    read_data_set,
)
from geotlm_lm.recordings.legible import require_any_legible
from geotlm_lm.recordings.pixels import with_square_pixels
from geotlm_lm.runs.run import ALONE, LOST, Workers, do_parts, run_folder
from geotlm_lm.track.export import Exported

if TYPE_CHECKING:
    import pyarrow

Values = NDArray[np.float32]

Columns = dict[str, list[Values]]
"""Name of a column -> its values in each episode, by the episode's number, (frames,)."""

LABELS_VERSION = 1
"""Of what is written of an episode: another version's are not continued."""

CAMERA_PREFIX = "observation.images."
"""Of most cameras' names; what is behind it begins the names of the columns."""

COLUMNS = 8
"""Three rates and the contact, each before its deviation."""

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


@dataclass(frozen=True)
class Labelling:
    """How episodes are tracked; a process that does so is given this.

    Args:
        root: Folder of the data set.
        camera: Name of the feature that is looked at.
        model: Folder of a model bundle; None takes the one shipped.
        square_pixels: As of `read_clip`.
        mm_per_px: Width on the gel of a pixel, mm; None gives travel in pixels of the frames.
    """

    root: Path
    camera: str
    model: Path | None = None
    square_pixels: bool | None = None
    mm_per_px: float | None = None

    @property
    def short_camera(self) -> str:
        """What begins the names of the columns."""
        return self.camera.removeprefix(CAMERA_PREFIX)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns, each before its deviation."""
        unit = "px" if self.mm_per_px is None else "mm"
        quantities = ("turn_deg_s", f"right_{unit}_s", f"down_{unit}_s", "contact")
        names = [f"{self.short_camera}.{quantity}" for quantity in quantities]
        return tuple(name for name in names for name in (name, f"{name}_deviation"))

    def columns(self, values: Sequence[Values]) -> Columns:
        """Return the columns by their names, of each episode's values, (frames, columns)."""
        return {name: [own[:, k] for own in values] for k, name in enumerate(self.names)}


@dataclass(frozen=True)
class LabelResult:
    """How many episodes, frames and events a run wrote, and why some have no labels, by number.

    `continued` are the episodes that an earlier, stopped run had tracked.
    """

    episodes: int
    frames: int
    events: int
    continued: int
    refused: dict[int, str]


Kept = tuple[Values, dict[str, Any]]
"""The columns of an episode, and its events, notes and why it was refused."""


def label_data_set(
    labelling: Labelling, out: Path, *, workers: Workers = ALONE, progress: Progress = silent
) -> LabelResult:
    """Write a LeRobot data set with the motion seen by a camera beside the original.

    Args:
        labelling: What is labelled, and how.
        out: Folder of the new data set.
        workers: Who tracks; the result does not depend on it. An episode that ends the process
            which tracks it gets no labels, but for `ALONE`, where that is this process.
        progress: Called after every episode.

    Raises:
        UnreadableClip: If the data set cannot be read.
        UsageError: If there is no such camera, if the data set is labelled already, if `out` holds
            something, or if an unfinished run of something else lies beside it.
        Unwritten: If it cannot be written.
        GeoTLMError: If no worker can be started.
    """
    data_set = read_data_set(labelling.root)
    data_set.require_camera(labelling.camera)
    folder = out.with_name(f"{out.name}.part")
    _require_free(data_set, labelling, out, folder / "data_set")
    require_whole(data_set)
    settings = _settings(data_set, labelling)
    jobs = [(episode, folder / f"episode-{episode.index:06d}.npz") for episode in data_set.episodes]
    with run_folder(folder, settings, "data set, camera or facts") as stamp:
        shutil.rmtree(folder / "data_set", ignore_errors=True)
        continued = do_parts(
            "labelled",
            # Without its episodes: each part has its own alone.
            partial(_label, labelling, replace(data_set, episodes=())),
            jobs,
            _save,
            is_kept=_is_kept,
            workers=workers,
            seen=[data_set.root / INFO, stamp],
            lost=partial(_lost, data_set.root),
            progress=progress,
        )
        values, abouts = zip(*(_load(path) for _, path in jobs), strict=True)
        events = [
            {"episode_index": n} | event
            for n, about in enumerate(abouts)
            for event in about["events"]
        ]
        refused = {n: about["refused"] for n, about in enumerate(abouts) if about["refused"]}
        made_by = settings | {
            "refused": {str(n): reason for n, reason in refused.items()},
            "notes": {str(n): about["notes"] for n, about in enumerate(abouts) if about["notes"]},
        }
        write_labelled(data_set, labelling.columns(values), folder / "data_set")
        _write_events(folder / "data_set/meta", labelling.short_camera, events, made_by)
        with uninterrupted_step():
            move_into_place(folder / "data_set", out)
            shutil.rmtree(folder)
    return LabelResult(len(jobs), sum(map(len, values)), len(events), continued, refused)


def _require_free(data_set: LeRobotDataSet, labelling: Labelling, out: Path, written: Path) -> None:
    column = next((name for name in labelling.names if name in data_set.features), None)
    if column is not None:
        raise UsageError(
            f"{data_set.root}: has a column {column} already, expected one without; give the "
            f"original data set."
        )
    if out.resolve().is_relative_to(data_set.root.resolve()):
        raise UsageError(
            f"--out: {out} lies in the data set that is read, expected a folder beside it; give "
            f"another place."
        )
    link = next((path for path in (out, written.parent, written) if path.is_symlink()), None)
    if link is not None:
        raise UsageError(
            f"--out: {link} is a link, through which something else would be written, expected a "
            f"new folder; delete it, or give another name."
        )
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(
            f"--out: {out} is there already and would be replaced, expected a new folder; give "
            f"another name."
        )


def _settings(data_set: LeRobotDataSet, labelling: Labelling) -> dict[str, Any]:
    """Return what decides the labels; the new data set keeps it beside the events."""
    episodes = [asdict(episode) for episode in data_set.episodes]
    content = json.dumps({"info": data_set.info, "episodes": episodes}, sort_keys=True)
    return {
        "labels": LABELS_VERSION,
        "made_by": f"geotlm-lm {__version__}",
        "model": loaded(labelling.model).bundle.digest(),
        "camera": labelling.camera,
        "square_pixels": labelling.square_pixels,
        "mm_per_px": labelling.mm_per_px,
        "of": hashlib.sha256(content.encode()).hexdigest()[:16],
    }


def _label(labelling: Labelling, data_set: LeRobotDataSet, episode: Episode) -> Kept:
    try:
        exported = _track(data_set, episode, labelling)
    except UnreadableClip as error:
        return _refused(episode, str(error))
    values = exported.to_dict()
    about = {"events": values["events"], "notes": values["notes"], "refused": None}
    return motion_values(exported, episode.length), about


def _lost(root: Path, episode: Episode) -> Kept:
    return _refused(episode, f"{root} episode {episode.index}: {LOST}")


def _refused(episode: Episode, reason: str) -> Kept:
    return _unknown(episode.length), {"events": [], "notes": [], "refused": reason}


def _track(data_set: LeRobotDataSet, episode: Episode, labelling: Labelling) -> Exported:
    """Return the track of an episode; one too long for memory is decoded anew, frame by frame."""
    is_square = labelling.square_pixels
    clip = episode_clip(data_set, episode, labelling.camera, square_pixels=is_square)
    require_any_legible(clip)
    tracker = loaded(labelling.model).tracker(clip)
    frames = clip.frames
    if len(clip) < episode.length:
        frames = episode_frames(data_set, episode, labelling.camera)
    for number, frame in enumerate(frames):
        tracker.feed(with_square_pixels(frame) if is_square else frame, number / data_set.fps)
    return Exported(tracker.finish(), labelling.mm_per_px)


def motion_values(exported: Exported, count: int) -> Values:
    """Return the columns of a track of `count` rows, in the order of `Labelling.names`, (count, 8).

    Rates are clockwise, right and down positive. A frame that was left out of the track has what
    lies between its neighbours. Contact is a probability; its deviation that of touching or not.
    """
    track = exported.track
    if not len(track):
        return _unknown(count)
    rates, deviations = track.rates()
    right, down = exported.units.travelled(rates[:, 1], rates[:, 2])
    right_deviation, down_deviation = exported.units.travelled(deviations[:, 1], deviations[:, 2])
    contact = track.contact
    columns = (
        *(rates[:, 0], deviations[:, 0]),
        *(right, right_deviation),
        *(down, down_deviation),
        *(contact, np.sqrt(contact * (1 - contact))),
    )
    rows = [np.interp(np.arange(count), track.numbers, column) for column in columns]
    return np.stack(rows, axis=1).astype(np.float32)


def _unknown(count: int) -> Values:
    return np.full((count, COLUMNS), np.nan, np.float32)


def _save(stream: IO[bytes], kept: Kept) -> None:
    values, about = kept
    np.savez(stream, values=values, about=np.array(json.dumps(about)))


def _load(file: Path) -> Kept | None:
    """Return what was kept of an episode; None where that is missing or damaged."""
    try:
        with np.load(file, allow_pickle=False) as stored:
            return stored["values"], json.loads(str(stored["about"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def _is_kept(episode: Episode, file: Path) -> bool:
    kept = _load(file)
    return kept is not None and len(kept[0]) == episode.length


# Writing: the same episodes with columns added; videos are linked.


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


def write_labelled(data_set: LeRobotDataSet, columns: Columns, out: Path) -> None:
    """Write the data set with more columns into a new folder, in which nothing may be."""
    rewritten = {data_set.data_path(episode) for episode in data_set.episodes}
    tables = {
        path.relative_to(data_set.root).as_posix()
        for path in sorted((data_set.root / EPISODES).glob("*/*.parquet"))
    }
    _copy_others(data_set.root, out, rewritten | tables | {INFO, STATISTICS})
    added = {name: {"dtype": "float32", "shape": [1], "names": None} for name in columns}
    features = data_set.features | added
    info = data_set.info | {"features": features}
    write_text_atomically(out / INFO, json.dumps(info, indent=4) + "\n")
    for name in sorted(rewritten):
        _write_rows(data_set.root / name, out / name, columns)
    for name in sorted(tables):
        _write_episodes(data_set.root / name, out / name, columns)
    _write_statistics(data_set, out / STATISTICS, columns)


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


def _write_rows(source: Path, target: Path, columns: Columns) -> None:
    """Write a table of frames with the columns, group of rows by group as it was."""
    import pyarrow
    from pyarrow import parquet

    with (
        plain_name(source) as plain,
        parquet.ParquetFile(plain) as file,
        replacing(target) as stream,
    ):
        added = [pyarrow.field(name, pyarrow.float32()) for name in columns]
        schema = pyarrow.schema([*file.schema_arrow, *added], file.schema_arrow.metadata)
        with parquet.ParquetWriter(stream, schema) as writer:
            for group in range(file.num_row_groups):
                with damage_as_sentence(source):
                    table = file.read_row_group(group)
                for name, values in columns.items():
                    table = table.append_column(name, pyarrow.array(_of_rows(table, values)))
                writer.write_table(table.cast(schema))


def _of_rows(table: pyarrow.Table, values: list[Values]) -> Values:
    episodes = table["episode_index"].to_numpy()
    frames = table["frame_index"].to_numpy()
    column = np.empty(len(frames), np.float32)
    for episode in np.unique(episodes):
        where = episodes == episode
        column[where] = values[episode][frames[where]]
    return column


def _write_episodes(source: Path, target: Path, columns: Columns) -> None:
    """Write a table of episodes with the columns' statistics, where it holds others'."""
    import pyarrow
    from pyarrow import parquet

    table = read_table(source)
    if any(name.startswith("stats/") for name in table.column_names):
        episodes = table["episode_index"].to_pylist()
        for name, values in columns.items():
            known = [_statistics_of(values[index]) for index in episodes]
            for kind in _statistics_of(np.zeros(1, np.float32)):  # of no episode, too
                whole = pyarrow.int64() if kind == "count" else pyarrow.float64()
                cells = pyarrow.array([column[kind] for column in known], pyarrow.list_(whole))
                table = table.append_column(f"stats/{name}/{kind}", cells)
    with replacing(target) as stream:
        parquet.write_table(table, stream)


def _read_statistics(data_set: LeRobotDataSet) -> dict[str, Any] | None:
    path = data_set.root / STATISTICS
    return read_object(path) if os.path.lexists(path) else None


def _write_statistics(data_set: LeRobotDataSet, target: Path, columns: Columns) -> None:
    statistics = _read_statistics(data_set)
    if statistics is None:  # none are kept of the other columns either
        return
    for name, values in columns.items():
        statistics[name] = _statistics_of(np.concatenate(values))
    write_text_atomically(target, json.dumps(statistics, indent=4) + "\n")


def _write_events(
    folder: Path, camera: str, events: list[dict[str, Any]], made_by: dict[str, Any]
) -> None:
    import pyarrow
    from pyarrow import parquet

    fields = [
        pyarrow.field(name, pyarrow.type_for_alias(kind)) for name, kind in _EVENT_TYPES.items()
    ]
    about = {"geotlm_lm": json.dumps(made_by)}
    table = pyarrow.Table.from_pylist(events, pyarrow.schema(fields, about))
    with replacing(folder / f"{camera}_events.parquet") as stream:
        parquet.write_table(table, stream)
