"""Clips with known motions that variants are judged on: simulated, real, public and semi-real.

Simulated clips show everyday objects that no weight was trained on. Real ones are windows of
labelled recordings, split in halves by what is touched. A semi-real clip carries the imprint of a
real touch (its change against the idle gel) over that gel by a known path, with fresh noise; it
lacks the change of lighting from place to place and the gel's creep.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from geotlm_lm.benchmarks.harness import Listing, Pivot, Row
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import Edit
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.data import tactile_tracking as tracking
from geotlm_lm.data.labelled_recordings import (
    LabelledRecordings,
    WindowRow,
    find_labelled_recordings,
)
from geotlm_lm.data.manifest import Manifest, read_manifest
from geotlm_lm.data.tactile_tracking import (
    TactileTracking,
    Trial,
    is_tactile_tracking,
    pair_clip,
    read_tactile_tracking,
)

if TYPE_CHECKING:
    from geotlm_lm.simulation.simulate import SimulatedClip

TASKS: dict[str, tuple[Motion, ...]] = {
    "rotation": ROTATIONS,
    "sliding": SLIDES,
    "all": tuple(Motion),
}
"""The paper's two tasks, and all ten motions together."""

MIXED_CLIPS = 600

MOST_TRIES = 6
"""Scenes simulated per clip asked for, at most: a bound on a search, not an expected number."""

Half = Literal["tune", "report"]
HALVES: tuple[Half, ...] = ("report", "tune")
"""Of the real recordings: what is reported, and what thresholds and bundles are chosen by."""

LISTED = tomllib.loads(Path(__file__).with_name("halves.toml").read_text(encoding="utf-8"))
"""Families by half, with the salt of those that are not listed."""

TUNE_TITLE = "Of the half that things are chosen by"
"""Over the tables of `tune`, which are never mixed with those of `report`."""

PAIRS_PER_TRIAL = 50
"""Pairs of each trial judged per task at most, evenly through it: neighbouring ones are nearly the
same, and the paper's totals are 49 and 76 a trial."""

DataSet = TactileTracking | Manifest

TrackedPairs = Sequence[tuple[Trial, Sequence[tracking.LabelledPair]]]


def simulated_cases(
    task: str, count: int, seed: int, left_out: Counter[str] | None = None
) -> Iterator[Case]:
    """Yield readable simulated clips of a task.

    `left_out["unreadable_left_out"]` counts those whose images do not show the motion.
    """
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
    from geotlm_lm.simulation.simulate import simulate_series

    root, most = seed_for(seed, "evaluation", task), MOST_TRIES * count
    for made in simulate_series(root, most, objects=EVERYDAY_OBJECTS, motions=TASKS[task]):
        if made.label.is_readable:
            name, label = made.object_name, made.label
            yield Case(made.clip, label.motion, name, amount=label.amount)
            count -= 1
            if not count:
                return
        elif left_out is not None:
            left_out["unreadable_left_out"] += 1


def simulated_mixtures(
    count: int, seed: int, gels: Mapping[str, float] | None = None
) -> Iterator[SimulatedClip]:
    """Yield simulated clips that turn, slide and press freely at once, readable or not.

    They are on a GelSight Mini, or on kinds of gel by their shares.
    """
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
    from geotlm_lm.simulation.simulate import simulate_series

    motions = [motion for motion in Motion if motion is not Motion.NONE]
    root = seed_for(seed, "evaluation", "mixtures")
    options = {"objects": EVERYDAY_OBJECTS, "motions": motions, "mixed_share": 1.0}
    options["gels"] = gels
    yield from simulate_series(root, count, **options)


def half_of(family: str) -> Half:
    """Return the half of a family of objects: as halves.toml says, else by its hash."""
    family = LISTED["same"].get(family, family)
    digest = hashlib.sha256(f"{LISTED['salt']}:{family}".encode()).digest()
    hashed: Half = "report" if digest[0] % 2 else "tune"
    return next((half for half in HALVES if family in LISTED[half]), hashed)


def rows_of_half(rows: Iterable[Any], half: Half | None) -> tuple[Any, ...]:
    """Return the rows of a half, by their `object_family`; all for None."""
    return tuple(row for row in rows if half in (None, half_of(row.object_family)))


def titled(title: str, half: Half | None) -> str:
    """Return the title of a set of a half's clips."""
    return title if half is None else f"{title}, {half}"


def is_reported(row: Row) -> bool:
    """Whether a row is not of the half that things are chosen by."""
    return f", {HALVES[1]}" not in row.case


def by_half(view: Listing | Pivot, title: str = "") -> dict[str, Listing | Pivot]:
    """Return a view twice: the halves of recordings are never shown in one table."""
    tune = f"{title}. {TUNE_TITLE}" if title else TUNE_TITLE
    return {
        title: replace(view, shows=lambda row: view.shows(row) and is_reported(row)),
        tune: replace(view, shows=lambda row: view.shows(row) and not is_reported(row)),
    }


def real_recordings(folder: Path | None) -> dict[str, LabelledRecordings]:
    """Return the labelled recordings of `folder`, or of each folder inside, by folder name.

    Raises:
        UnreadableClip: If there are none, or none with a usable direction.
    """
    if folder is None:
        return {}
    recordings = find_labelled_recordings(folder)
    usable = {own.folder.resolve().name: own for own in recordings if own.rows}
    if not usable:
        skipped = sum((own.skipped for own in recordings), Counter())
        if not skipped:
            raise UnreadableClip(
                f"{folder}: the tables of windows hold no row; write one row per motion."
            )
        raise UnreadableClip(
            f"{folder}: no row has a usable direction (left out: {dict(skipped)}); expected one of "
            f"{', '.join(Motion)}."
        )
    return usable


def recordings_by_half(folder: Path | None) -> Iterator[tuple[str, Half, LabelledRecordings]]:
    """Yield each folder of labelled recordings by name, once for each half with its rows."""
    for name, real in real_recordings(folder).items():
        for half in HALVES:
            yield name, half, replace(real, rows=rows_of_half(real.rows, half))


def by_task(recordings: LabelledRecordings) -> dict[str, LabelledRecordings]:
    """Split recordings whose labels are of more than one task, so that each is asked as a task.

    The keys are what to add to the name: nothing where all labels are of one task.
    """
    others = tuple(motion for motion in Motion if motion not in DIRECTED)
    tasks = {" rotation": ROTATIONS, " sliding": SLIDES, " without direction": others}
    parts = {
        name: tuple(row for row in recordings.rows if row.motion in among)
        for name, among in tasks.items()
    }
    kept = {name: rows for name, rows in parts.items() if rows}
    if len(kept) == 1:
        return {"": recordings}
    return {name: replace(recordings, rows=rows) for name, rows in kept.items()}


def task_of(rows: Iterable[WindowRow]) -> tuple[Motion, ...]:
    """Return the smallest task that holds every label."""
    held = {row.motion for row in rows}
    return next(x for x in (ROTATIONS, SLIDES, DIRECTED, tuple(Motion)) if held <= set(x))


def window_cases(recordings: LabelledRecordings) -> Iterator[Case]:
    """Yield each window as four frames and as a pair, both forwards and backwards."""
    for window in recordings.windows(frames=("four", "pair"), backwards=True):
        tags = {
            "frames": window.frames,
            "played": "backwards" if window.is_backwards else "forwards",
            "fps": "unknown" if window.clip.fps is None else f"{window.clip.fps:g}",
        }
        row = window.row
        yield Case(window.clip, window.motion, row.object_family, tags)


def held_across(case: Case) -> Case:
    """Show a clip as a sensor held across records it, turned by 90 degrees counterclockwise."""
    return replace(
        case, clip=turned_by_quarter(case.clip), motion=Edit.of("quarter-ccw").of_way(case.motion)
    )


def turned_by_quarter(clip: Clip) -> Clip:
    """Return a clip turned by 90 degrees counterclockwise."""
    frames = np.ascontiguousarray(np.rot90(clip.frames, axes=(1, 2)))
    idle = clip.background
    idle = None if idle is None else np.ascontiguousarray(np.rot90(idle))
    return replace(clip, frames=frames, background=idle)


def open_data_sets(paths: Sequence[Path]) -> dict[str, DataSet]:
    """Read TactileTracking's folders and manifests; return them by the names their tables get.

    Raises:
        UnreadableClip: If a path is neither, or nothing in it can be used.
        UsageError: If two have one name.
    """
    opened: dict[str, DataSet] = {}
    for path in paths:
        if is_tactile_tracking(path):
            data_set = read_tactile_tracking(path)
            name = f"TactileTracking {data_set.folder.resolve().name}"
        elif path.is_dir():
            raise UnreadableClip(
                f"{path}: holds no trials of TactileTracking, expected folders with poses; give "
                f"another folder, a manifest's file, or labelled recordings with --real."
            )
        else:
            data_set = read_manifest(path)
            name = f"manifest {data_set.path.stem}"
        if name in opened:
            raise UsageError(f"{path}: another data set is called '{name}' too; rename one.")
        opened[name] = data_set
    return opened


def listed_cases(manifest: Manifest, among: Sequence[Motion]) -> Iterator[Case]:
    """Yield the clips of a manifest that show motions of a task, each read whole."""
    for row, clip in manifest.clips(among):
        tags = {"sensor": row.sensor or "unnamed"}
        yield Case(clip, row.motion, row.object_id, tags)


def tracked_pairs(data: TactileTracking, task: str) -> tuple[TrackedPairs, dict[str, Any]]:
    """Choose the pairs to judge, and tell how: no method has seen a pair by then.

    The paper gives the number of its pairs and no threshold. The rule of the sweep is taken that
    comes nearest to that number, in proportion to the trials that are here.
    """
    usual = tracking.PairRule()
    swept = tracking.sweep_pair_counts(data.trials, usual, task)
    target = tracking.PAPER_PAIRS[task] * len(data.trials) / tracking.PAPER_TRIALS
    chosen = tracking.nearest_rule(swept, usual, task, target)
    labelled = [(trial, tracking.labelled_pairs(trial, chosen, task)) for trial in data.trials]
    judged = [(trial, tracking.evenly_spaced(own, PAIRS_PER_TRIAL)) for trial, own in labelled]
    facts = {
        "rule": asdict(chosen),
        "found": sum(len(own) for _, own in labelled),
        "paper": tracking.PAPER_PAIRS[task],
        "paper_share": len(data.trials) / tracking.PAPER_TRIALS,
    }
    return judged, facts


def pair_cases(pairs: TrackedPairs) -> Iterator[Case]:
    """Yield pairs of frames of TactileTracking's trials, as clips a, a, b, b."""
    for trial, own in pairs:
        recording = trial.recording() if own else None
        for pair in own:
            clip = pair_clip(recording, trial, pair)
            yield Case(clip, pair.motion, trial.object_id)
