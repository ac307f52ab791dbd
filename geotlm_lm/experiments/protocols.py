"""The paper's protocols on simulated clips of everyday objects, through one frozen backbone.

Clips are encoded once; every fold of every row is kept as soon as it is done, so that a run that
was stopped continues, and a finished one is put together again in seconds.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from geotlm_lm.backbone.tokens import Backbone
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.record import RunRecord
from geotlm_lm.evaluation.fold_scores import fold_scores, right_rows
from geotlm_lm.evaluation.splits import Fold, leave_one_object_out, object_folds
from geotlm_lm.evaluation.uncertainty import paired_difference
from geotlm_lm.experiments.cases import TASKS
from geotlm_lm.experiments.evaluate import one_thread
from geotlm_lm.experiments.folder_tables import Progress
from geotlm_lm.experiments.protocol_clips import (
    ProtocolClips,
    TaskClips,
    backbone_digest,
    cache_folder,
    read_or_encode,
    source_digest,
)
from geotlm_lm.experiments.protocol_folds import Outcome, run_folds
from geotlm_lm.experiments.protocol_rows import CONTRASTS, TABLES, TASKS_OF, rows_of
from geotlm_lm.training.geometry import BATCH, DGR_RATE, HEAD_RATE, WEIGHT_DECAY

SEED = 42
"""Paper: the seed is 42 offset by the fold's number."""

EPOCHS = 30
"""Paper, implementation details."""

FOLD_COUNT = 5

FIVE_FOLD = "five-fold"
LEAVE_ONE_OUT = "leave-one-object-out"

PROTOCOLS: dict[str, Callable[[Sequence[str], int], list[Fold]]] = {
    FIVE_FOLD: lambda objects, seed: object_folds(objects, FOLD_COUNT, seed=seed),
    LEAVE_ONE_OUT: lambda objects, seed: leave_one_object_out(objects, seed=seed),
}
"""How clips are dealt into folds of three parts, no object in two of them."""

SOURCES = (
    "core",
    "dgr",
    "probe",
    "evaluation",
    "training",
    "experiments/protocol_folds.py",
    "experiments/protocol_rows.py",
)
"""Rooms and files whose code decides what a fold comes to."""


@dataclass(frozen=True)
class ProtocolSizes:
    """How much is run.

    Args:
        objects: What is touched; at least `FOLD_COUNT`.
        clips: Readable simulated clips of each object in each task.
        epochs: Epochs of every training.
        seed: Root of scenes, folds and, with the fold's number added, of training.
    """

    objects: tuple[str, ...]
    clips: int
    epochs: int = EPOCHS
    seed: int = SEED


def run_protocols(
    backbone: Backbone,
    sizes: ProtocolSizes,
    *,
    folder: Path,
    tables: tuple[str, ...] = tuple(TABLES),
    backbone_name: str = "embedded",
    about: Mapping[str, Any] | None = None,
    command: str = "",
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Run the rows of some tables under both protocols.

    Args:
        backbone: The frozen backbone.
        sizes: How much is run.
        folder: Tokens and finished folds are kept here, each set in a folder of its own name.
        tables: Names in `TABLES`.
        backbone_name: What the record calls the backbone.
        about: What else the record says of it.
        command: The command line, for the record.
        progress: Told how far the run is.

    Raises:
        UsageError: If a table is unknown, there are too few objects for the folds, or the simulator
            finds too few readable clips.
    """
    _check(sizes, tables)
    started = time.perf_counter()
    kept = cache_folder(folder, backbone, _wanted(sizes))
    tasks = dict.fromkeys(task for name in tables for task in TASKS_OF[name])
    with one_thread():
        found = {task: _run_task(task, backbone, sizes, kept, tables, progress) for task in tasks}
    return RunRecord(
        name="protocols",
        command=command,
        seed=sizes.seed,
        seconds=time.perf_counter() - started,
        numbers={"tasks": found},
        config=asdict(sizes)
        | dict(about or {})
        | {
            "objects": list(sizes.objects),
            "tables": list(tables),
            "backbone": backbone_name,
            "backbone_digest": backbone_digest(backbone),
            "tokens": kept.name,
            "training": {
                "head_rate": HEAD_RATE,
                "dgr_rate": DGR_RATE,
                "weight_decay": WEIGHT_DECAY,
                "batch": BATCH,
            },
            "threads": 1,
        },
    )


def _check(sizes: ProtocolSizes, tables: tuple[str, ...]) -> None:
    unknown = [name for name in tables if name not in TABLES]
    if unknown:
        raise UsageError(f"there is no table '{unknown[0]}'; choose one of {', '.join(TABLES)}.")
    if len(set(sizes.objects)) < FOLD_COUNT:
        raise UsageError(
            f"{len(set(sizes.objects))} objects were given, expected at least {FOLD_COUNT}; give "
            f"one for each fold."
        )


def _wanted(sizes: ProtocolSizes) -> ProtocolClips:
    return ProtocolClips(sizes.objects, sizes.clips, sizes.seed)


def _run_task(
    task: str,
    backbone: Backbone,
    sizes: ProtocolSizes,
    kept: Path,
    tables: tuple[str, ...],
    progress: Progress,
) -> dict[str, Any]:
    """Return one task's clips in numbers, and both protocols."""
    clips = read_or_encode(kept, backbone, _wanted(sizes), task, progress)
    rows = rows_of(tables, task, has_truth=clips.has_truth)
    protocols, seconds = {}, clips.seconds
    for protocol, deal in PROTOCOLS.items():
        folds = deal(clips.objects, sizes.seed)
        total = len(folds) * len(rows)

        def tell(done: int, title: str = f"{task}, {protocol}, rows", total: int = total) -> None:
            progress(title, done, total)

        outcomes = run_folds(
            clips,
            task,
            folds,
            rows,
            epochs=sizes.epochs,
            seed=sizes.seed,
            keep=_places(kept, task, protocol, sizes),
            progress=tell,
        )
        protocols[protocol] = _scored(clips, folds, rows, outcomes)
        seconds += sum(one["seconds"] for fold in outcomes for one in fold.values())
    return {
        "clips": len(clips.objects),
        "truths": {motion.value: clips.truths.count(motion) for motion in TASKS[task]},
        "unreadable_left_out": clips.unreadable,
        "seconds_from_nothing": seconds,
        "protocols": protocols,
    }


def _places(kept: Path, task: str, protocol: str, sizes: ProtocolSizes) -> Callable[[int], Path]:
    """Return where each fold's outcomes are kept, under a name that its settings decide."""
    about = json.dumps([sizes.epochs, sizes.seed, source_digest(*SOURCES)])
    digest = hashlib.sha256(about.encode()).hexdigest()[:12]
    return lambda number: kept / f"folds-{digest}" / f"{task}-{protocol}-{number:02d}.json"


def _scored(
    clips: TaskClips,
    folds: Sequence[Fold],
    rows: Sequence[str],
    outcomes: Sequence[Mapping[str, Outcome]],
) -> dict[str, Any]:
    """Return the scores of every row, the differences of pairs, and who stood in which part."""
    truths = [motion.value for motion in clips.truths]
    named = {row: [fold[row]["predictions"] for fold in outcomes] for row in rows}
    right = {row: right_rows(truths, folds, named[row]) for row in rows}
    scores = {
        row: fold_scores(truths, clips.objects, folds, named[row])
        | {
            "parameters": outcomes[0][row].get("parameters", 0),
            "best_epoch": [fold[row].get("best_epoch") for fold in outcomes],
        }
        for row in rows
    }
    differences = [
        {"first": first, "second": second}
        | asdict(paired_difference(right[first], right[second], clips.objects))
        for first, second in CONTRASTS
        if first in right and second in right
    ]
    return {"folds": _parts(clips, folds), "rows": scores, "differences": differences}


def _parts(clips: TaskClips, folds: Sequence[Fold]) -> list[dict[str, Any]]:
    """Return the objects of each fold's three parts, and how many clips they hold."""

    def names(rows: Sequence[int]) -> list[str]:
        return list(dict.fromkeys(clips.objects[row] for row in rows))

    return [
        {part: names(rows) for part, rows in parts.items()}
        | {"clips": [len(rows) for rows in parts.values()]}
        for fold in folds
        for parts in [{"train": fold.train, "val": fold.val, "test": fold.test}]
    ]
