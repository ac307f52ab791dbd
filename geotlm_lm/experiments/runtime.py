"""Error against run time of every way to name a motion, measured in turn in one run.

Each repeat puts every clip to every method before the next, so that a busy spell slows all alike.
Times are wall times on the threads stated; memory is of fresh processes.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm.core.record import RunRecord
from geotlm_lm.evaluation.uncertainty import wilson_interval
from geotlm_lm.experiments.evaluate import threads
from geotlm_lm.experiments.runtime_clips import (
    KnownClip,
    real_clips,
    simulated_clips,
    turning_clips,
)
from geotlm_lm.experiments.runtime_methods import Ask, Timed, flow_group, model_groups

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

Progress = Callable[[str, int, int], None]
QUIET: Progress = lambda what, done, total: None  # noqa: E731


@dataclass(frozen=True)
class RuntimeSizes:
    """How much is measured.

    Args:
        clips: Simulated clips of each task.
        real_windows: Windows of each folder of real recordings.
        repeats: Times every clip is put to every method; 1 more is not counted.
        fitted_clips: Simulated turns that Curl + LR is fitted on.
        precisions: Number formats of the model.
        batches: Clips at once.
        batch_repeats: Times of each batch, and of each stage in parts of 10.
        threads: Threads of one process.
        cold_runs: Fresh processes of every command, after one that warms the file cache.
    """

    clips: int = 60
    real_windows: int = 40
    repeats: int = 3
    fitted_clips: int = 400
    precisions: tuple[str, ...] = ("float32", "bfloat16", "int8")
    batches: tuple[int, ...] = (1, 2, 4, 8, 16, 32, 64)
    batch_repeats: int = 3
    threads: tuple[int, ...] = (1, 2)
    cold_runs: int = 5


SIZES = {
    "default": RuntimeSizes(),
    "tiny": RuntimeSizes(
        clips=2,
        real_windows=1,
        repeats=1,
        fitted_clips=6,
        precisions=("float32", "int8"),
        batches=(1, 2),
        batch_repeats=1,
        threads=(1,),
        cold_runs=1,
    ),
}


def runtime(
    answerer: Answerer,
    *,
    sizes: RuntimeSizes = SIZES["default"],
    seed: int = 0,
    real_folder: Path | None = None,
    model: Path | None = None,
    command: str = "",
    progress: Progress = QUIET,
) -> RunRecord:
    """Measure everything.

    Args:
        answerer: The model.
        sizes: How much of it.
        seed: Root of the clips.
        real_folder: Labelled recordings, measured in addition.
        model: The folder that the model was loaded from, for fresh processes; None for the one
            that ships.
        command: The command line, for the record.
        progress: Told how far the run is.

    Raises:
        UnreadableClip: If the recordings cannot be read.
        CommandFailed: If a command exits with an error in its fresh process.
    """
    started = time.perf_counter()
    clips = list(simulated_clips(sizes.clips, seed))
    if real_folder is not None:
        clips += real_clips(real_folder, sizes.real_windows)
    groups = model_groups(answerer, sizes.precisions)
    left_out = [one for one in sizes.precisions if one not in groups]
    numbers = _in_this_process(answerer, groups, clips, sizes, seed, progress)
    fresh = _in_fresh_processes(sizes, model, progress)
    numbers["omissions"] += fresh.pop("omissions")
    return RunRecord(
        name="runtime",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers=numbers | fresh,
        config={
            "clips_per_task": sizes.clips,
            "real_windows": sizes.real_windows if real_folder else 0,
            "repeats": sizes.repeats,
            "fitted_clips": sizes.fitted_clips,
            "left_out": left_out,
            "model_digest": answerer.bundle.digest(),
        },
    )


def _in_this_process(
    answerer: Answerer,
    groups: Mapping[str, Ask],
    clips: Sequence[KnownClip],
    sizes: RuntimeSizes,
    seed: int,
    progress: Progress,
) -> dict[str, Any]:
    from geotlm_lm.experiments import model_omissions, runtime_batches, runtime_stages
    from geotlm_lm.probe.curl import CurlRegression

    many, first = 10 * sizes.batch_repeats, clips[0].clip
    with threads(1):
        curl = CurlRegression.fit(*turning_clips(sizes.fitted_clips, seed))
        asked = {"classical": flow_group(curl), **groups}
        numbers = {
            "methods": method_rows(asked, clips, sizes.repeats, progress),
            "stages": runtime_stages.stage_rows(answerer, first, many),
            "omissions": model_omissions.omission_rows(answerer, first, many),
        }
    whole = [known.clip for known in clips if known.frames > 2]
    return numbers | {"batches": runtime_batches.batch_rows(answerer, whole, sizes, progress)}


def _in_fresh_processes(
    sizes: RuntimeSizes, model: Path | None, progress: Progress
) -> dict[str, Any]:
    from geotlm_lm.experiments import model_omissions, runtime_processes

    return {
        "memory": runtime_processes.memory_rows(model, progress),
        "commands": runtime_processes.command_rows(sizes.cold_runs, model, progress),
        "omissions": model_omissions.import_rows(sizes.cold_runs),
    }


def method_rows(
    groups: Mapping[str, Ask],
    clips: Sequence[KnownClip],
    repeats: int,
    progress: Progress = QUIET,
) -> list[dict[str, Any]]:
    """Return one row per method, source of clips and number of frames.

    Args:
        groups: What asks its methods, by name.
        clips: What they are asked about.
        repeats: Times each clip is put to each, after once that is not timed.
        progress: Told how far the run is.
    """
    found: dict[tuple[str, str, int], list[tuple[KnownClip, list[Timed]]]] = defaultdict(list)
    places: dict[tuple[str, int], list[Timed]] = {}
    for repeat in range(repeats + 1):
        for number, known in enumerate(clips):
            for name, timed in _asked_in_turn(groups, known, repeat + number):
                if repeat == 0:
                    places[name, number] = own = []
                    found[name, known.source, known.frames].append((known, own))
                else:
                    places[name, number].append(timed)
        progress("methods, repeat", repeat, repeats)
    return [
        {"method": name, "source": source, "frames": frames, **_scores(answers)}
        for (name, source, frames), answers in found.items()
    ]


def _asked_in_turn(
    groups: Mapping[str, Ask], known: KnownClip, turn: int
) -> Iterable[tuple[str, Timed]]:
    """Yield what every method made of a clip; another group begins at each turn."""
    names = list(groups)
    first = turn % len(names)
    for name in names[first:] + names[:first]:
        yield from groups[name](known.clip, known.among).items()


def _scores(answers: Sequence[tuple[KnownClip, list[Timed]]]) -> dict[str, Any]:
    right = [all(one.motion == known.motion for one in own) for known, own in answers]
    milliseconds = [one.milliseconds for _, own in answers for one in own]
    share = float(np.mean(right))
    low, high = wilson_interval(share, len(right))
    return {
        "clips": len(right),
        "error": 1 - share,
        "error_interval": [1 - high, 1 - low],
        **spread(milliseconds),
        **_measured_errors(answers),
    }


def _measured_errors(answers: Sequence[tuple[KnownClip, list[Timed]]]) -> dict[str, float | None]:
    """Return the median error of measured turns and slides; None where none is measured."""
    turns, slides = [], []
    for known, own in answers:
        said = own[0]
        if known.turn_deg is not None and said.turn_deg is not None:
            turns.append(abs(said.turn_deg - known.turn_deg))
        if known.slide_px is not None and said.slide_px is not None:
            slides.append(float(np.hypot(*np.subtract(said.slide_px, known.slide_px))))
    return {
        "turn_error_deg": float(np.median(turns)) if turns else None,
        "slide_error_px": float(np.median(slides)) if slides else None,
    }


def spread(milliseconds: Sequence[float]) -> dict[str, float]:
    """Return median, quartiles and 95th percentile, in milliseconds."""
    shares = {"ms_q25": 0.25, "ms_median": 0.5, "ms_q75": 0.75, "ms_p95": 0.95}
    return {name: float(np.quantile(milliseconds, share)) for name, share in shares.items()}
