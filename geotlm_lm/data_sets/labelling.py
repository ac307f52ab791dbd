"""Labels a whole LeRobot data set by tracking each of its episodes; a stopped run is continued.

The columns of each episode are kept in `NAME.part` beside the new data set until all are there, so
that a reader never sees half of it. Same bytes whatever the number of processes.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import zipfile
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from geotlm_lm import __version__
from geotlm_lm.answering.answerer import loaded
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.files import move_into_place
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.data_sets.labelled import Labels, Values, require_whole, write_labelled
from geotlm_lm.data_sets.layout import INFO
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

LABELS_VERSION = 1
"""Of what is written of an episode: another version's are not continued."""

CAMERA_PREFIX = "observation.images."
"""Of most cameras' names; what is behind it begins the names of the columns."""

COLUMNS = 8
"""Three rates and the contact, each before its deviation."""


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
        events_file = f"meta/{labelling.short_camera}_events.parquet"
        labels = Labels(labelling.names, values, events, events_file, made_by)
        write_labelled(data_set, labels, folder / "data_set")
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
    content = json.dumps({"info": data_set.info.content, "episodes": episodes}, sort_keys=True)
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
