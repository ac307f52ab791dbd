"""Clips a second of a data set written by every usable core, and the memory a worker needs."""

from __future__ import annotations

import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from geotlm_lm.experiments.runtime_memory import most_held_megabytes
from geotlm_lm.simulation.dataset import SHARD_CLIPS, write_dataset
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS

Progress = Callable[[str, int, int], None]

KINDS: dict[str, dict[str, Any]] = {
    "fast": {"preset": "fast"},
    "draft": {"preset": "draft"},
    "fast, labels only": {"preset": "fast", "with_frames": False},
    "fast, with friction": {"preset": "fast", "with_drift": True},
}
"""What is written -> options of `write_dataset`."""

REPEATS = 3

SHARDS_PER_WORKER = 8


def simulator_rates(
    *,
    workers: int,
    kinds: Mapping[str, Mapping[str, Any]] = KINDS,
    repeats: int = REPEATS,
    shards_per_worker: int = SHARDS_PER_WORKER,
    progress: Progress = lambda what, done, total: None,
) -> list[dict[str, Any]]:
    """Write data sets in turn and return a row per kind: clips a second, and peak memory.

    A rate counts from the first finished shard to the last, as `geotlm-lm simulate` shows it:
    starting up is apart, in `start_seconds`. A row's `megabytes_per_worker` is the most that any
    worker ever held (VmHWM), None where the system does not tell.

    Args:
        workers: Processes, one thread each.
        kinds: Name -> options of `write_dataset`.
        repeats: Data sets of each kind, with other clips each time.
        shards_per_worker: Size of one.
        progress: Told how far the run is.
    """
    count = SHARD_CLIPS * shards_per_worker * workers
    rows: dict[str, dict[str, Any]] = {
        name: {"kind": name, "workers": workers, "clips": count, "clips_per_second": []}
        | {"start_seconds": [], "load": [], "megabytes_per_worker": None}
        for name in kinds
    }
    for repeat in range(repeats):
        for done, (name, options) in enumerate(kinds.items(), start=1):
            run = _one_run(count, repeat, workers, options)
            row = rows[name]
            for key in ("clips_per_second", "start_seconds", "load"):
                row[key].append(run[key])
            held = [one for one in (row["megabytes_per_worker"], run["megabytes"]) if one]
            row["megabytes_per_worker"] = max(held, default=None)
            progress("rates", repeat * len(kinds) + done, repeats * len(kinds))
    return list(rows.values())


def _one_run(count: int, seed: int, workers: int, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return one data set's rate, its start-up, the load before it and its workers' memory."""
    reports: list[tuple[float, int]] = []
    held: list[float] = []

    def note(what: str, done: int, total: int) -> None:
        reports.append((time.perf_counter(), done))
        for worker in multiprocessing.active_children():
            held.extend(filter(None, [most_held_megabytes(worker.pid)]))

    load = os.getloadavg()[0]
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        write_dataset(
            Path(folder) / "clips",
            count,
            seed=seed,
            objects=TRAINING_OBJECTS,
            workers=workers,
            marker_share=0.0,
            progress=note,
            **options,
        )
    (first, before), (last, after) = reports[0], reports[-1]
    return {
        "clips_per_second": (after - before) / (last - first),
        "start_seconds": first - begun,
        "load": load,
        "megabytes": max(held, default=None),
    }
