"""The main table: language model, linear probes and classical flow on clips none of them has seen.

Runs everything on one thread, so that the times of the rows compare.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.record import RunRecord
from geotlm_lm.data.touch_table import (
    TABLE_NAME,
    read_directed,
    read_touch_table,
    read_untouched,
)
from geotlm_lm.experiments.cases import (
    TASKS,
    UNREADABLE,
    QuarterTurned,
    RealCases,
    SimulatedCases,
    StartingInContact,
    by_task,
    real_cases,
)
from geotlm_lm.experiments.compare import (
    Method,
    Replies,
    ask_all,
    per_object,
    summarise,
)
from geotlm_lm.experiments.data_sets import judge_data_set, open_data_sets
from geotlm_lm.experiments.folder_tables import (
    Progress,
    judge_made,
    judge_negatives,
    judge_whole,
    telling,
)
from geotlm_lm.experiments.methods import (
    BY_OBJECT,
    CONTRASTS,
    GENERATED,
    all_methods,
    in_question,
)

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer


def evaluate(
    answerer: Answerer,
    *,
    clips_per_task: int,
    seed: int,
    real_folder: Path | None = None,
    data_paths: Sequence[Path] = (),
    model_name: str = "embedded",
    command: str = "",
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Judge a model against its references.

    Args:
        answerer: The loaded model.
        clips_per_task: Readable simulated clips per task; 0 leaves the simulated tasks out.
        seed: Root of scenes, question wordings and resampling.
        real_folder: Labelled recordings, judged in addition.
        data_paths: Data sets judged in addition: TactileTracking's folder, or a manifest.
        model_name: What the record calls the model.
        command: The command line, for the record.
        progress: Told how far the run is.

    Raises:
        UnreadableClip: If the recordings or a data set cannot be read, or nothing was judged.
        UsageError: If two data sets have one name.
    """
    recordings = {} if real_folder is None else real_cases(real_folder)
    data_sets = open_data_sets(data_paths)
    started = time.perf_counter()
    methods = all_methods(answerer, seed)
    tables: dict[str, Any] = {}
    about: dict[str, Any] = {}
    with one_thread():
        if clips_per_task:
            tables |= judge_simulator(methods, clips_per_task, seed, progress)
        for name, real in recordings.items():
            tables |= judge_recordings(methods, name, real, seed, progress)
        for name, data_set in data_sets.items():
            found, about[name] = judge_data_set(methods, data_set, seed, progress)
            tables |= found
    if not tables:
        raise UnreadableClip(f"no clip could be judged ({_left_out(about)}); give other data.")
    return RunRecord(
        name="evaluate",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers={"tables": tables, "minimum": minimum_accuracy(tables)}
        | ({"data_sets": about} if about else {}),
        config={
            "model": model_name,
            "model_digest": answerer.bundle.digest(),
            "clips_per_task": clips_per_task,
            "real": {name: len(cases.recordings.rows) for name, cases in recordings.items()},
            "threads": 1,
        },
    )


def judge_simulator(
    methods: Mapping[str, Method], clips_per_task: int, seed: int, progress: Progress
) -> dict[str, Any]:
    """Return the tables of every simulated task, by a steady and by an unsteady hand."""
    tables = {}
    for task in TASKS:
        for is_unsteady in (False, True):
            cases = SimulatedCases(
                task, clips_per_task, seed, is_unsteady=is_unsteady, with_unreadable=True
            )
            tables[cases.title] = judge_simulated(methods, cases, seed, progress)
    return tables


def judge_simulated(
    methods: Mapping[str, Method], cases: SimulatedCases, seed: int, progress: Progress
) -> dict[str, Any]:
    """Return the table of one simulated task, and how many clips left out of it were named."""

    def tell(done: int) -> None:
        progress(cases.title, done - cases.unreadable, cases.count)

    replies = ask_all(in_question(methods, cases.among), cases, cases.among, tell)
    left_out = replies.where(**UNREADABLE)
    return _table(replies.without(**UNREADABLE), seed) | {
        "unreadable_left_out": cases.unreadable,
        "unreadable_right": int(left_out.right(GENERATED).sum()) if len(left_out) else 0,
    }


def judge_recordings(
    methods: Mapping[str, Method], name: str, real: RealCases, seed: int, progress: Progress
) -> dict[str, Any]:
    """Return every table of one folder: its windows task by task, and what else it can be asked."""
    tables: dict[str, Any] = {}
    for part, cases in by_task(real).items():
        tables |= judge_real(methods, name + part, cases, seed, progress)
        for aside, shown in (
            ("no idle frame", StartingInContact(cases.recordings)),
            ("turned by a quarter", QuarterTurned(cases.recordings)),
        ):
            title = f"real {name}{part}, {aside}"
            replies = ask_all(
                in_question(methods, cases.among),
                shown,
                cases.among,
                telling(progress, title, len(shown)),
            )
            tables[title] = _table(replies, seed) | _by_object(replies)
    table = real.recordings.folder / TABLE_NAME
    directed, touched = read_directed(table), read_touch_table(table)
    tables |= judge_whole(methods, name, directed, seed, progress) if directed else {}
    tables |= judge_made(methods, name, touched, seed, progress) if touched else {}
    return tables | judge_negatives(methods, name, touched, read_untouched(table), seed, progress)


def judge_real(
    methods: Mapping[str, Method], name: str, cases: RealCases, seed: int, progress: Progress
) -> dict[str, Any]:
    """Return the tables of one folder: four frames and pairs, and each way of playing apart.

    Frame rates are told apart too where there are several: cameras set to another rate often have
    another gain and zoom.
    """

    def tell(done: int) -> None:
        progress(f"real {name}", done, len(cases))

    replies = ask_all(in_question(methods, cases.among), cases, cases.among, tell)
    left_out = {"rows_left_out": dict(cases.recordings.skipped)}
    rates = sorted({tags["fps"] for tags in replies.tags})
    tables = {}
    for frames, title in (("four", "four frames"), ("pair", "pairs")):
        part = replies.where(frames=frames)
        tables[f"real {name}, {title}"] = _table(part, seed) | left_out | _by_object(part)
        for played in ("forwards", "backwards"):
            key = f"real {name}, {title}, {played}"
            tables[key] = _table(part.where(played=played), seed)
        for rate in rates if len(rates) > 1 else ():
            tables[f"real {name}, {title}, {rate} fps"] = _table(part.where(fps=rate), seed)
    return tables


def minimum_accuracy(tables: Mapping[str, Any]) -> float | None:
    """Return the lowest accuracy of the language model's own words over all tables."""
    found = [table["methods"][GENERATED]["accuracy"] for table in tables.values()]
    return min(found, default=None)


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let torch and OpenCV use `count` threads each while inside."""
    import cv2
    import torch

    torch_before, cv2_before = torch.get_num_threads(), cv2.getNumThreads()
    torch.set_num_threads(count)
    cv2.setNumThreads(count)
    try:
        yield
    finally:
        torch.set_num_threads(torch_before)
        cv2.setNumThreads(cv2_before)


def _left_out(about: Mapping[str, Any]) -> str:
    """Return how many files of each data set were left out, and the first reason."""
    counts = [f"{one['left_out']['count']} left out of {name}" for name, one in about.items()]
    reasons = [reason for one in about.values() for reason in one["left_out"]["first"]]
    return "; ".join([*counts, *reasons[:1]]) or "none was asked for"


def one_thread() -> AbstractContextManager[None]:
    """Keep torch and OpenCV on one thread each while inside."""
    return threads(1)


def _by_object(replies: Replies) -> dict[str, Any]:
    return {"by_object": per_object(replies, BY_OBJECT)}


def _table(replies: Replies, seed: int) -> dict[str, Any]:
    return summarise(replies, CONTRASTS, seed=seed)
