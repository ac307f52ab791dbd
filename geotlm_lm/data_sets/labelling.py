"""Labels a whole LeRobot data set by tracking each of its episodes; a stopped run is resumed.

What is done of each episode is kept in `NAME.part` beside the new data set until all is there, so
that a reader of it never sees half of one. Same bytes whatever the number of processes.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import zipfile
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm import __version__
from geotlm_lm.answering.loaded import loaded
from geotlm_lm.core.atomic import (
    move_into_place,
    only_writer,
    replacing,
    write_text_atomically,
)
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.interrupts import uninterrupted_step
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.data_sets.episode_frames import episode_clip, episode_frames
from geotlm_lm.data_sets.labelled import Labels, require_whole, write_labelled
from geotlm_lm.data_sets.layout import INFO
from geotlm_lm.data_sets.lerobot import Episode, LeRobotDataSet, read_data_set
from geotlm_lm.data_sets.motion_columns import (
    CAMERA_PREFIX,
    Values,
    column_names,
    motion_values,
    unknown_values,
)
from geotlm_lm.recordings.legible import require_any_legible
from geotlm_lm.recordings.pixel_shape import with_square_pixels
from geotlm_lm.track.export import Exported
from geotlm_lm.workers import ALONE, LOST, Workers

SETTINGS = "settings.json"

LABELS_VERSION = 1
"""Of what is written of an episode: another version's are not continued."""


@dataclass(frozen=True)
class Labelling:
    """How episodes are tracked; a process that does so is given this.

    Args:
        root: Folder of the data set.
        camera: Name of the feature that is looked at.
        model: Folder of a model bundle; None takes the one shipped.
        square_pixels: As of `read_clip`.
        mm_per_px: Width on the gel of a pixel, mm; None tells travel in pixels of the frames.
    """

    root: Path
    camera: str
    model: Path | None = None
    square_pixels: bool | None = None
    mm_per_px: float | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return column_names(self.camera, "px" if self.mm_per_px is None else "mm")


@dataclass(frozen=True)
class LabelResult:
    """What a run wrote.

    Args:
        episodes: How many the data set has.
        frames: Of all of them.
        events: Rows of the events' table.
        continued: Episodes that an earlier, stopped run had tracked.
        refused: What was amiss with those that could not be tracked, by their number.
    """

    episodes: int
    frames: int
    events: int
    continued: int
    refused: dict[int, str]


def label_data_set(
    labelling: Labelling, out: Path, *, workers: Workers = ALONE, progress: Progress = silent
) -> LabelResult:
    """Write a LeRobot data set with the motion seen by a camera beside the original.

    Args:
        labelling: What is labelled, and how.
        out: Folder of the new data set.
        workers: Who tracks; the result does not depend on it. An episode that ends the process
            which tracks it gets no labels, but for `ALONE`, where that is this process.
        progress: Told how many episodes are done.

    Raises:
        UnreadableClip: If the data set cannot be read.
        UsageError: If there is no such camera, if the data set is labelled already, if `out` holds
            something, or if an unfinished run of something else lies beside it.
        Unwritten: If it cannot be written.
        GeoTLMError: If no worker can be started.
    """
    data_set = read_data_set(labelling.root)
    data_set.require_camera(labelling.camera)
    part = out.with_name(f"{out.name}.part")
    _require_free(data_set, labelling, out, part)
    require_whole(data_set)
    with only_writer(part) as is_alone:
        if not is_alone:
            raise UsageError(
                f"{part}: another run is writing it, expected one at a time; wait for it, or give "
                f"another --out."
            )
        settings = _settings(data_set, labelling)
        _begin(part, settings)
        files = [part / f"episode-{one.index:06d}.npz" for one in data_set.episodes]
        missing = [
            _Part(one, file)
            for one, file in zip(data_set.episodes, files, strict=True)
            if _kept(file, one) is None
        ]
        continued = done = len(files) - len(missing)
        # Without its episodes: each part has its own alone.
        work = partial(_label_episode, labelling, replace(data_set, episodes=()))
        lost = partial(_label_lost, data_set.root)
        seen = [data_set.root / INFO, part / SETTINGS]
        for _ in workers.each_done(work, missing, seen=seen, lost=lost):
            done += 1
            progress("labelled", done, len(files))
        result = _assemble(data_set, labelling, files, settings, part / "data_set")
        with uninterrupted_step():
            move_into_place(part / "data_set", out)
            shutil.rmtree(part)
    return LabelResult(len(files), result[0], result[1], continued, result[2])


@dataclass(frozen=True)
class _Part:
    episode: Episode
    file: Path


def _require_free(data_set: LeRobotDataSet, labelling: Labelling, out: Path, part: Path) -> None:
    there = next((one for one in labelling.names if one in data_set.features), None)
    if there is not None:
        raise UsageError(
            f"{data_set.root}: has a column {there} already, expected one without; give the "
            f"original data set."
        )
    if out.resolve().is_relative_to(data_set.root.resolve()):
        raise UsageError(
            f"--out: {out} lies in the data set that is read, expected a folder beside it; give "
            f"another place."
        )
    link = next((path for path in (out, part, part / "data_set") if path.is_symlink()), None)
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
    """Return what decides the labels, so that no other run's are taken for them."""
    episodes = [asdict(episode) for episode in data_set.episodes]
    told = json.dumps({"info": data_set.info.content, "episodes": episodes}, sort_keys=True)
    return {
        "labels": LABELS_VERSION,
        "made_by": f"geotlm-lm {__version__}",
        "model": loaded(labelling.model).bundle.digest(),
        "camera": labelling.camera,
        "square_pixels": labelling.square_pixels,
        "mm_per_px": labelling.mm_per_px,
        "of": hashlib.sha256(told.encode()).hexdigest()[:16],
    }


def _begin(part: Path, settings: dict[str, Any]) -> None:
    """Begin a run in a folder, or go on with the one that was stopped there."""
    path = part / SETTINGS
    if part.exists():
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            found = None
        if found != settings and (found is not None or any(part.iterdir())):
            raise UsageError(
                f"{part}: belongs to a run of another data set, camera, model or version, expected "
                f"this one's; delete it to begin anew, or give another --out."
            )
    write_text_atomically(path, json.dumps(settings) + "\n")
    shutil.rmtree(part / "data_set", ignore_errors=True)


def _label_episode(labelling: Labelling, data_set: LeRobotDataSet, part: _Part) -> int:
    """Track an episode and keep what is told of it, if that is not there."""
    episode = part.episode
    if _kept(part.file, episode) is not None:
        return episode.index
    try:
        exported = _tracked(data_set, episode, labelling)
    except UnreadableClip as error:
        return _keep(part, unknown_values(episode.length), refused=str(error))
    told = {name: exported.to_dict()[name] for name in ("events", "notes")}
    return _keep(part, motion_values(exported, episode.length), **told)


def _label_lost(root: Path, part: _Part) -> int:
    """Keep no labels of an episode that ends the process which tracks it."""
    values = unknown_values(part.episode.length)
    return _keep(part, values, refused=f"{root} episode {part.episode.index}: {LOST}")


def _keep(
    part: _Part, values: Values, *, events: Any = (), notes: Any = (), refused: str | None = None
) -> int:
    told = json.dumps({"events": list(events), "notes": list(notes), "refused": refused})
    with uninterrupted_step(), replacing(part.file) as stream:
        np.savez(stream, values=values, told=np.array(told))
    return part.episode.index


def _tracked(data_set: LeRobotDataSet, episode: Episode, labelling: Labelling) -> Exported:
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


def _kept(file: Path, episode: Episode) -> tuple[Values, dict[str, Any]] | None:
    """Return what was kept of an episode; None where that is missing or damaged."""
    try:
        with np.load(file, allow_pickle=False) as stored:
            values, told = stored["values"], json.loads(str(stored["told"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return (values, told) if len(values) == episode.length else None


def _assemble(
    data_set: LeRobotDataSet,
    labelling: Labelling,
    files: list[Path],
    settings: dict[str, Any],
    folder: Path,
) -> tuple[int, int, dict[int, str]]:
    """Write the data set and return its frames, its events and what was refused."""
    kept = [_kept(file, one) for file, one in zip(files, data_set.episodes, strict=True)]
    values, told = zip(*kept, strict=True)
    events = [{"episode_index": n} | event for n, one in enumerate(told) for event in one["events"]]
    refused = {n: one["refused"] for n, one in enumerate(told) if one["refused"] is not None}
    notes = {str(n): one["notes"] for n, one in enumerate(told) if one["notes"]}
    short = labelling.camera.removeprefix(CAMERA_PREFIX)
    made_by = settings | {"refused": {str(n): why for n, why in refused.items()}, "notes": notes}
    labels = Labels(labelling.names, values, events, f"meta/{short}_events.parquet", made_by)
    write_labelled(data_set, labels, folder)
    return sum(map(len, values)), len(events), refused
