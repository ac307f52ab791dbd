"""The model as a partner in conversation: every question type, and groups of questions.

Runs everything on one thread through the product's own seams; parse failures count as wrong.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.cases import real_cases
from geotlm_lm.experiments.evaluate import one_thread
from geotlm_lm.experiments.language_asking import ask_every_type
from geotlm_lm.experiments.language_cases import Touched, real_touches, simulated_touches
from geotlm_lm.experiments.language_groups import ask_groups
from geotlm_lm.experiments.language_scores import summarise_talk

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many clips are done, and how many there are."""


def evaluate_talk(
    answerer: Answerer,
    *,
    clips: int,
    seed: int,
    real_folder: Path | None = None,
    windows: int = 0,
    model_name: str = "embedded",
    command: str = "",
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Ask a model everything it can be asked, and grade it.

    Args:
        answerer: The loaded model.
        clips: Readable simulated clips of objects no weight was trained on; 0 leaves them out.
        seed: Root of scenes, questions and resampling.
        real_folder: Labelled recordings, asked about in addition.
        windows: How many of their windows at most, per folder; each is also played backwards.
        model_name: What the record calls the model.
        command: The command line, for the record.
        progress: Told how far the run is.

    Raises:
        UnreadableClip: If the recordings cannot be read.
    """
    recordings = {} if real_folder is None else real_cases(real_folder)
    started = time.perf_counter()
    sets: dict[str, Any] = {}

    def told(what: str) -> Callable[[int, int], None]:
        return lambda done, total: progress(what, done, total)

    with one_thread():
        if clips:
            seen = simulated_touches(answerer, clips, seed, told("simulated, perceived"))
            sets["simulated"] = talk_about(answerer, list(seen), seed, progress, "simulated")
        for name, cases in recordings.items():
            title = f"real {name}"
            seen = real_touches(answerer, cases, windows, told(f"{title}, perceived"))
            sets[title] = talk_about(answerer, list(seen), seed, progress, title)
    return RunRecord(
        name="language",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers={"sets": sets},
        config={
            "model": model_name,
            "model_digest": answerer.bundle.digest(),
            "kinds_trained": sorted(answerer.bundle.grammar.kinds),
            "clips": clips,
            "windows": windows,
            "threads": 1,
        },
    )


def talk_about(
    answerer: Answerer, touches: list[Touched], seed: int, progress: Progress, title: str
) -> dict[str, Any]:
    """Return the scores of one set of clips."""
    rows = ask_every_type(answerer, touches, seed, lambda *at: progress(f"{title}, asked", *at))
    groups = ask_groups(answerer, touches, seed, lambda *at: progress(f"{title}, groups", *at))
    return summarise_talk(rows, groups, seed)
