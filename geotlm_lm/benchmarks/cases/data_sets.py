"""Public data sets that users bring: TactileTracking's trials, and clips listed in a manifest.

Each is judged as the paper's two tasks, rotation and sliding, with the object as the unit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.data import tactile_tracking
from geotlm_lm.data.manifest import Manifest, read_manifest
from geotlm_lm.data.tactile_tracking import (
    TactileTracking,
    Trial,
    is_tactile_tracking,
    pair_clip,
    read_tactile_tracking,
)

DATA_TASKS: dict[str, tuple[Motion, ...]] = {"rotation": ROTATIONS, "sliding": SLIDES}

PAIRS_PER_TRIAL = 50
"""Pairs of each trial judged per task at most, evenly through it: neighbouring ones are nearly the
same, and the paper's totals are 49 and 76 a trial."""

DataSet = TactileTracking | Manifest

TrackedPairs = Sequence[tuple[Trial, Sequence[tactile_tracking.LabelledPair]]]
"""Trials, and the pairs of frames that are judged of each."""


def pair_cases(pairs: TrackedPairs) -> Iterator[Case]:
    """Yield pairs of frames of TactileTracking's trials, as clips a, a, b, b."""
    for trial, own in pairs:
        recording = trial.recording() if own else None
        for pair in own:
            clip = pair_clip(recording, trial, pair)
            yield Case(clip, pair.motion, trial.object_id, trial.object_id)


def listed_cases(manifest: Manifest, among: Sequence[Motion]) -> Iterator[Case]:
    """Yield the clips of a manifest that show motions of a task, each read whole."""
    for row, clip in manifest.clips(among):
        tags = {"sensor": row.sensor or "unnamed"}
        yield Case(clip, row.motion, row.object_id, row.object_id, tags)


def open_data_set(path: Path) -> DataSet:
    """Read TactileTracking's folder, or a manifest.

    Raises:
        UnreadableClip: If it is neither, or nothing in it can be used.
    """
    if is_tactile_tracking(path):
        return read_tactile_tracking(path)
    if path.is_dir():
        raise UnreadableClip(
            f"{path}: holds no trials of TactileTracking, expected folders with poses; give "
            f"another folder, a manifest's file, or labelled recordings with --real."
        )
    return read_manifest(path)


def open_data_sets(paths: Sequence[Path]) -> dict[str, DataSet]:
    """Read data sets; return them by the names their tables get.

    Raises:
        UnreadableClip: As of `open_data_set`.
        UsageError: If two have one name.
    """
    found: dict[str, DataSet] = {}
    for path in paths:
        name = data_set_name(data_set := open_data_set(path))
        if name in found:
            raise UsageError(f"{path}: another data set is called '{name}' too; rename one.")
        found[name] = data_set
    return found


def data_set_name(data_set: DataSet) -> str:
    """Return what tables call a data set."""
    if isinstance(data_set, Manifest):
        return f"manifest {data_set.path.stem}"
    return f"TactileTracking {data_set.folder.resolve().name}"


def tracked_pairs(data: TactileTracking, task: str) -> tuple[TrackedPairs, dict[str, Any]]:
    """Choose the pairs to judge, and tell how: no method has seen a pair by then.

    The paper gives the number of its pairs and no threshold. The rule of the sweep is taken that
    comes nearest to that number, in proportion to the trials that are here.
    """
    usual = tactile_tracking.PairRule()
    swept = tactile_tracking.sweep_pair_counts(data.trials, usual, task)
    target = tactile_tracking.PAPER_PAIRS[task] * len(data.trials) / tactile_tracking.PAPER_TRIALS
    chosen = tactile_tracking.nearest_rule(swept, usual, task, target)
    found = [(trial, tactile_tracking.labelled_pairs(trial, chosen, task)) for trial in data.trials]
    judged = [(trial, tactile_tracking.evenly_spaced(own, PAIRS_PER_TRIAL)) for trial, own in found]
    facts = {
        "rule": asdict(chosen),
        "found": sum(len(own) for _, own in found),
        "paper": tactile_tracking.PAPER_PAIRS[task],
        "paper_share": len(data.trials) / tactile_tracking.PAPER_TRIALS,
    }
    return judged, facts
