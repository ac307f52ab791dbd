"""Public data sets that users bring: TactileTracking's trials, and clips listed in a manifest.

Each is judged as the paper's two tasks, rotation and sliding, with the object as the unit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.data.manifest import Manifest, read_manifest
from geotlm_lm.data.pose_pairs import (
    PAPER_PAIRS,
    PAPER_TRIALS,
    LabelledPair,
    PairRule,
    evenly,
    labelled_pairs,
    nearest_rule,
    sweep,
)
from geotlm_lm.data.tactile_tracking import (
    TactileTracking,
    Trial,
    is_tactile_tracking,
    pair_clip,
    read_tactile_tracking,
)
from geotlm_lm.experiments.compare import Case, Method, ask_all, summarise
from geotlm_lm.experiments.methods import CONTRASTS, in_question
from geotlm_lm.recordings.choose import choose_frames

DATA_TASKS: dict[str, tuple[Motion, ...]] = {"rotation": ROTATIONS, "sliding": SLIDES}

PAIRS_PER_TRIAL = 50
"""Pairs of each trial judged per task at most, evenly through it: neighbouring ones are nearly the
same, and the paper's totals are 49 and 76 a trial."""

NAMED_LEFT_OUT = 20
"""Files left out that a record names; all are counted."""

DataSet = TactileTracking | Manifest


@dataclass(frozen=True, eq=False)
class TrackedPairs:
    """Pairs of frames of TactileTracking's trials, as clips a, a, b, b.

    Args:
        pairs: Each trial with its labelled pairs.
    """

    pairs: Sequence[tuple[Trial, Sequence[LabelledPair]]]

    def __len__(self) -> int:
        return sum(len(own) for _, own in self.pairs)

    def __iter__(self) -> Iterator[Case]:
        for trial, own in self.pairs:
            if not own:
                continue
            recording = trial.recording()
            for pair in own:
                clip = pair_clip(recording, trial, pair)
                tags = {"trial": trial.folder.name}
                yield Case(clip, pair.motion, trial.object_id, trial.object_id, tags)


@dataclass(frozen=True, eq=False)
class ListedClips:
    """The clips of a manifest that show one task: four frames each, as a user's clip is cut.

    Args:
        manifest: The manifest.
        among: The task's motions.
    """

    manifest: Manifest
    among: tuple[Motion, ...]

    def __len__(self) -> int:
        return sum(row.motion in self.among for row in self.manifest.rows)

    def __iter__(self) -> Iterator[Case]:
        for row, clip in self.manifest.clips(self.among):
            tags = {"sensor": row.sensor or "unnamed"}
            yield Case(choose_frames(clip), row.motion, row.object_id, row.object_id, tags)


def open_data_set(path: str | Path) -> DataSet:
    """Read TactileTracking's folder, or a manifest.

    Raises:
        UnreadableClip: If it is neither, or nothing in it can be used.
    """
    path = Path(path)
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
        data_set = open_data_set(path)
        name = data_set_name(data_set)
        if name in found:
            raise UsageError(f"{path}: another data set is called '{name}' too; rename one.")
        found[name] = data_set
    return found


def judge_data_set(
    methods: Mapping[str, Method],
    data_set: DataSet,
    seed: int,
    progress: Callable[[str, int, int], None],
    contrasts: Sequence[tuple[str, str]] = CONTRASTS,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the tables of a data set, and what is to be known of it beside them.

    Args:
        methods: The rows of every table.
        data_set: From `open_data_set`.
        seed: Root of the resampling.
        progress: Told how far the run is.
        contrasts: Pairs of methods to compare.

    Returns:
        Tables by title; and left_out, the backgrounds and, for TactileTracking, the sweeps of its
        thresholds.
    """
    name, tables, sweeps = data_set_name(data_set), {}, {}
    for task, among in DATA_TASKS.items():
        title, facts = f"{name}, {task}", {}
        if isinstance(data_set, Manifest):
            cases: TrackedPairs | ListedClips = ListedClips(data_set, among)
        else:
            cases, facts, sweeps[task] = tracked_pairs(data_set, task)

        def tell(done: int, title: str = title, total: int = len(cases)) -> None:
            progress(title, done, total)

        replies = ask_all(in_question(methods, among), cases, among, tell)
        if not len(replies):
            continue
        tables[title] = summarise(replies, contrasts, seed=seed) | facts
        sensors = sorted({tags.get("sensor", "") for tags in replies.tags})
        for sensor in sensors if len(sensors) > 1 else ():
            part = replies.where(sensor=sensor)
            tables[f"{title}, sensor {sensor}"] = summarise(part, contrasts, seed=seed)
    left_out = list(data_set.left_out.values())
    about = {"left_out": {"count": len(left_out), "first": left_out[:NAMED_LEFT_OUT]}}
    return tables, about | {"backgrounds": _backgrounds(data_set), "sweeps": sweeps}


def data_set_name(data_set: DataSet) -> str:
    """Return what tables call a data set."""
    if isinstance(data_set, Manifest):
        return f"manifest {data_set.path.stem}"
    return f"TactileTracking {data_set.folder.resolve().name}"


def tracked_pairs(
    data: TactileTracking, task: str, rule: PairRule | None = None
) -> tuple[TrackedPairs, dict[str, Any], list[dict[str, Any]]]:
    """Choose the pairs to judge: those of the swept thresholds that come nearest to the paper's.

    The paper gives the number of its pairs and no threshold. Numbers of pairs alone choose, in
    proportion to the trials that are here; no method has seen a pair by then.

    Args:
        data: The trials.
        task: "rotation" or "sliding".
        rule: The thresholds that are not swept.

    Returns:
        The pairs; facts for their table; and the sweep.
    """
    usual = rule or PairRule()
    rows = sweep(data.trials, usual, task)
    target = PAPER_PAIRS[task] * len(data.trials) / PAPER_TRIALS
    chosen = nearest_rule(rows, usual, task, target)
    found = [(trial, labelled_pairs(trial, chosen, task)) for trial in data.trials]
    cases = TrackedPairs([(trial, evenly(own, PAIRS_PER_TRIAL)) for trial, own in found])
    facts = {
        "rule": asdict(chosen),
        "found": sum(len(own) for _, own in found),
        "paper": PAPER_PAIRS[task],
        "paper_share": len(data.trials) / PAPER_TRIALS,
    }
    return cases, {"pairs": facts}, rows


def _backgrounds(data_set: DataSet) -> dict[str, Any]:
    """Return where the backgrounds come from, as plain JSON values."""
    if isinstance(data_set, Manifest):
        return dict(data_set.backgrounds)
    gel = data_set.gel
    if gel is None:
        return {}
    return {
        "estimated where untouched, trials": len(data_set.trials),
        "share of the view touched in every frame": gel.covered_share,
        "largest difference of a trial's light": float(abs(gel.gains - 1).max()),
    }
