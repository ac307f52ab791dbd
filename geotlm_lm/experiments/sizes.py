"""Language models of several sizes on one frozen perception: what error buys what run time.

All are trained for the same steps on the same simulated clips, fewer than the shipped one, and
asked the same questions about everyday objects that no weight has seen. What compares is the rows
with each other, not with the shipped model.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.answering import Answerer
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.record import RunRecord
from geotlm_lm.data.templates import load_templates
from geotlm_lm.experiments.evaluate import one_thread
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.language.speak import Speaker
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
from geotlm_lm.simulation.series import SERIES_VERSION
from geotlm_lm.training.config import DEFAULT
from geotlm_lm.training.examples import (
    VARIED,
    WORN_SHARE,
    Examples,
    ExampleSet,
    read_examples,
    simulate_examples,
)
from geotlm_lm.training.language import LanguageTraining, train_language
from geotlm_lm.training.scoring import ClipSet, score_bundle
from geotlm_lm.training.train import claim_folder, example_sets, perceive_examples

SHIPPED = LanguageSize()

SIZES: dict[str, LanguageSize] = {
    "64 wide, 2 layers": replace(SHIPPED, width=64, layers=2, heads=2, mlp=172),
    "128 wide, 2 layers": replace(SHIPPED, layers=2),
    "128 wide, 4 layers": SHIPPED,
    "128 wide, 4 layers, 1 prefix token": replace(SHIPPED, tactile_tokens=1),
    "128 wide, 4 layers, 4 prefix tokens": replace(SHIPPED, tactile_tokens=4),
    "256 wide, 4 layers": replace(SHIPPED, width=256, heads=8, mlp=688),
}
"""What is compared, each with 2 prefix tokens where it does not say otherwise."""

QUESTION = "Which way is it moving?"
TIMED_CLIPS = 60


@dataclass(frozen=True)
class Budget:
    """How much is simulated and trained.

    Args:
        clips: Simulated clips to learn from.
        test_clips: Clips of everyday objects to be asked about.
        steps: Of every language model, before its cooldown.
        batch: Questions per step.
    """

    clips: int = 8_000
    test_clips: int = 500
    steps: int = 2_000
    batch: int = 64


def compare_sizes(
    answerer: Answerer,
    *,
    folder: Path,
    budget: Budget,
    seed: int,
    workers: int,
    sizes: dict[str, LanguageSize] | None = None,
    command: str = "",
) -> RunRecord:
    """Train and judge a language model of every size.

    Args:
        answerer: The model whose perception they all read; its own words are not used.
        folder: Keeps clips and checkpoints: a stopped run continues there.
        budget: How much is simulated and trained.
        seed: Root of clips, weights and questions.
        workers: Processes that simulate.
        sizes: What is compared; None for `SIZES`.
        command: The command line, for the record.

    Raises:
        UsageError: If the folder holds clips of another seed or series, or checkpoints of other
            lengths.
    """
    started, sizes = time.perf_counter(), SIZES if sizes is None else sizes
    train_set, test_set = _perceived(answerer, folder, budget, seed, workers)
    # Another perception's tokens are another training: its checkpoints lie elsewhere.
    checkpoints, rows = folder / answerer.bundle.digest(), []
    for name, size in sizes.items():
        config = LanguageTraining(steps=budget.steps, batch=budget.batch, seed=seed, size=size)
        speaker = _trained(train_set, config, checkpoints / _slug(name), name)
        # The words are those of today's templates, whatever the shipped model was taught.
        grammar = load_templates().grammar()
        bundle = replace(answerer.bundle, speaker=speaker, grammar=grammar)
        rows.append(
            {
                "name": name,
                "is_shipped_size": size == SHIPPED,
                "parameters": sum(one.numel() for one in speaker.model.parameters()),
            }
            | _judged(bundle, test_set, seed)
            | _times(Answerer(bundle), test_set)
        )
    return RunRecord(
        name="sizes",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers={"rows": rows},
        config={
            "model_digest": answerer.bundle.digest(),
            "clips": len(train_set.labels),
            "test_clips": len(test_set.readable()),
            "steps": LanguageTraining(steps=budget.steps).all_steps,
            "batch": budget.batch,
        },
    )


def _perceived(
    answerer: Answerer, folder: Path, budget: Budget, seed: int, workers: int
) -> tuple[ClipSet, ClipSet]:
    """Return the clips to learn from and those to be asked about, as the model perceives them."""
    sets = simulated_sets(folder, budget.clips, budget.test_clips, seed, workers)
    learned, asked = (perceive_examples(answerer.bundle.model, one) for one in sets)
    return learned.only(learned.readable()), asked


def simulated_sets(
    folder: Path, clips: int, test_clips: int, seed: int, workers: int
) -> tuple[Examples, Examples]:
    """Return clips of training objects to learn from, and plain ones of everyday objects.

    Args:
        folder: Keeps them; what lies there already is not simulated again.
        clips: How many to learn from.
        test_clips: How many to be asked about.
        seed: Root of the clips.
        workers: Processes that simulate.

    Raises:
        UsageError: If the folder holds clips of another seed or series.
    """
    objects = example_sets(DEFAULT)["heads"].objects
    learned = ExampleSet("sizes", clips, objects)
    asked = ExampleSet("sizes_test", test_clips, EVERYDAY_OBJECTS, is_varied=False)
    about = {"series": SERIES_VERSION, "varied": VARIED, "worn": WORN_SHARE}
    claim_folder(folder, {"seed": seed} | about)
    simulate_examples(folder / "examples", (learned, asked), seed=seed, workers=workers)
    return read_examples(folder / "examples", learned), read_examples(folder / "examples", asked)


def _trained(clips: ClipSet, config: LanguageTraining, folder: Path, name: str) -> Speaker:
    """Return the language model of one row; its checkpoint lies in `folder`."""
    return train_language(
        clips.fused_tokens,
        clips.labels,
        config=config,
        folder=folder,
    )


def _judged(bundle: Bundle, clips: ClipSet, seed: int) -> dict[str, Any]:
    """Return the share of right answers: of the open question by task, of every type by wording."""
    scores = score_bundle(bundle, clips, seed)
    by_type = scores["by_type"]

    def mean(wordings: str) -> float:
        return float(np.mean([v for k, v in by_type.items() if k.endswith(f" {wordings}")]))

    return {
        "rotation": scores["rotation"]["generated"],
        "sliding": scores["sliding"]["generated"],
        "seen": mean("seen"),
        "held_out": mean("held_out"),
        "by_type": by_type,
    }


def _times(answerer: Answerer, clips: ClipSet) -> dict[str, float]:
    """Return milliseconds of weighing an open question and of writing its answer, on one thread."""
    speaker = answerer.bundle.speaker
    options = answerer.bundle.grammar.options_for("direction")
    weighed, written = [], []
    with one_thread():
        for token in clips.fused_tokens[:TIMED_CLIPS]:
            started = time.perf_counter()
            speaker.weigh(token, QUESTION, options)
            weighed.append(1e3 * (time.perf_counter() - started))
            started = time.perf_counter()
            speaker.generate(token[None], [QUESTION])
            written.append(1e3 * (time.perf_counter() - started))
    return {
        f"{name}_{kind}": float(value)
        for name, times in (("weigh_ms", weighed), ("write_ms", written))
        for kind, value in (("median", np.median(times)), ("p95", np.quantile(times, 0.95)))
    }


def _slug(name: str) -> str:
    return name.replace(",", "").replace(" ", "_")
