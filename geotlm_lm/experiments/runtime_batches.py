"""What many clips at once, and more threads, do for the model's milliseconds per clip."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.clip import Clip
from geotlm_lm.experiments.evaluate import threads
from geotlm_lm.experiments.judging import QUESTION
from geotlm_lm.experiments.runtime import RuntimeSizes, spread
from geotlm_lm.experiments.runtime_methods import changed_answerer
from geotlm_lm.probe.rigid_flow import RigidFlow

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

Work = Callable[[list[Clip]], object]


def batch_rows(
    answerer: Answerer,
    clips: Sequence[Clip],
    sizes: RuntimeSizes,
    progress: Callable[[str, int, int], None],
) -> list[dict[str, Any]]:
    """Return one row per work, precision, number of threads and batch: milliseconds per clip.

    The works are run in turn, repeat by repeat; a batch repeats clips where there are too few.
    """
    models = {"float32": answerer} | {
        precision: changed
        for precision in sizes.precisions
        if precision != "float32" and (changed := changed_answerer(answerer, precision)) is not None
    }
    works = {
        (name, precision): work
        for precision, model in models.items()
        for name, work in batch_works(model).items()
    }
    works["flow + fit, fast", "float32"] = lambda batch: [RigidFlow().fit(clip) for clip in batch]
    rows = []
    done = 0
    for count in sizes.threads:
        with threads(count):
            for size in sizes.batches:
                batch = [clips[number % len(clips)] for number in range(size)]
                times = _in_turn(works, batch, sizes.batch_repeats)
                rows += [
                    {"work": name, "precision": precision, "threads": count, "batch": size}
                    | spread(times[name, precision])
                    for name, precision in works
                ]
                done += 1
                progress("batches", done, len(sizes.threads) * len(sizes.batches))
    return rows


def batch_works(answerer: Answerer) -> dict[str, Work]:
    """Return what is done with a batch of clips of four frames, by name; each perceives first."""
    model, speaker, grammar = (
        answerer.bundle.model,
        answerer.bundle.speaker,
        answerer.bundle.grammar,
    )
    sentences = grammar.options_for("direction")

    def perceive(batch: list[Clip]) -> object:
        return model.perceive(batch)

    def probe(batch: list[Clip]) -> object:
        return model.probe.predict(model.perceive(batch).fused_token)

    def words(batch: list[Clip]) -> object:
        return speaker.generate(model.perceive(batch).fused_token, [QUESTION] * len(batch))

    def scores(batch: list[Clip]) -> object:
        tokens = model.perceive(batch).fused_token
        return [speaker.score(token, QUESTION, sentences) for token in tokens]

    return {"perceive": perceive, "probe on z": probe, "LM generated": words, "LM scored": scores}


def _in_turn(
    works: dict[tuple[str, str], Work], batch: list[Clip], repeats: int
) -> dict[tuple[str, str], list[float]]:
    """Return milliseconds per clip of every repeat, after one that is not timed."""
    times: dict[tuple[str, str], list[float]] = {key: [] for key in works}
    for repeat in range(repeats + 1):
        for key, work in works.items():
            started = time.perf_counter()
            work(batch)
            took = 1e3 * (time.perf_counter() - started) / len(batch)
            if repeat:
                times[key].append(took)
    return times
