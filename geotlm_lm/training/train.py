"""Make a whole bundle from nothing: simulate, pretrain, freeze, read geometry, learn to speak.

Every stage leaves its result in the run folder, so that an interrupted run continues where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from torch import Tensor

from geotlm_lm.backbone.vit import FrozenBackbone
from geotlm_lm.checkpoint import Bundle, Calibration, load_bundle, save_bundle
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.record import commit, machine
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.generation import Speaker
from geotlm_lm.motion.network import BELIEF_NUMBERS
from geotlm_lm.query.grammar import corpus, grammar
from geotlm_lm.query.labelled import TUNE, Labelled, labelled
from geotlm_lm.query.reader import Reader
from geotlm_lm.training.calibration import (
    calibrated_reader,
    fit_contact_threshold,
    fit_temperature,
)
from geotlm_lm.training.card import write_card
from geotlm_lm.training.config import HeadsPreset, TrainingPreset, preset_named
from geotlm_lm.training.dense_targets import DenseHeads
from geotlm_lm.training.examples import (
    Examples,
    read_examples,
    simulate_examples,
)
from geotlm_lm.training.language import FELT_BATCH, LanguageTraining, train_language
from geotlm_lm.training.motion import motion_scores
from geotlm_lm.training.perceiving import perceive_examples
from geotlm_lm.training.pretraining import pretrain
from geotlm_lm.training.ranks import ALONE, Ranks, joined
from geotlm_lm.training.reading import ReadingTraining, train_reader
from geotlm_lm.training.run_clock import clock
from geotlm_lm.training.run_folder import about_examples, claim_folder, example_sets
from geotlm_lm.training.scoring import (
    ClipSet,
    felt_likelihoods,
    felt_scores,
    score_bundle,
    true_option_likelihoods,
)
from geotlm_lm.training.seeing import Seen, train_to_see


def train(
    preset: str,
    out: Path,
    seed: int,
    workers: int,
    progress: Progress = silent,
    device: str | None = None,
) -> Path:
    """Train the bundle of `preset` and return its folder, `out`/bundle.

    Of several processes that torchrun started, all take the steps of backbone, language model and
    reader; the first one does what is left and writes, and the others wait.

    Args:
        preset: Name of a preset.
        out: Run folder; a run of the same preset and seed in it is continued.
        seed: Root seed; on one machine, the same seed and workers give the same weights.
        workers: Processes that simulate, and threads of each process that trains.
        progress: Told how far it is, by the first process alone.
        device: cpu or cuda; None for cuda where there is one.

    Raises:
        UsageError: If the preset or device is unknown, a batch does not divide among the processes
            or the folder holds another run.
        MissingDependency: If there are too few GPUs.
    """
    settings = preset_named(preset)
    torch.set_num_threads(max(workers, 1))
    cv2.setNumThreads(1)
    with joined(device) as ranks:
        batches = settings.pretraining_batch, settings.language_batch, settings.reading_batch
        ranks.refuse_uneven(*batches, FELT_BATCH)
        ranks.from_first(lambda: claim_folder(out, about_examples(settings, seed)))
        with clock(out) if ranks.is_first else nullcontext(lambda: 0.0) as seconds:
            run = _Run(settings, out, seed, workers, progress if ranks.is_first else silent, ranks)
            run.train(seconds)
    return out / "bundle"


@dataclass(frozen=True)
class _Run:
    """One process's part in a training; fields as `train` has them."""

    settings: TrainingPreset
    out: Path
    seed: int
    workers: int
    progress: Progress
    ranks: Ranks

    def train(self, seconds: Callable[[], float]) -> None:
        """Take every stage in turn; `seconds` tells how long the run has taken."""
        self.ranks.from_first(self._simulate)
        learned = self._examples("heads", "pretraining")
        backbone, read_outs = pretrain(
            learned,
            preset=self.settings,
            seed=self.seed,
            folder=self.out,
            first=self.settings.fresh_clips,
            ranks=self.ranks,
            progress=self.progress,
        )
        seen = self._see(backbone, read_outs, learned) if self.ranks.is_first else None
        del learned
        readings, labels = self.ranks.from_first(lambda: seen.readings())
        told = self.settings, self.seed, self.out, self.progress, self.ranks
        speaker = train_speaker(readings, labels, *told)
        reader = reader_of(
            self.settings,
            self.seed,
            self.out / "reader",
            self.progress,
            self.ranks,
            workers=self.workers,
        )
        self.ranks.from_first(lambda: self._finish(seen, speaker, reader, seconds))

    def _simulate(self) -> None:
        sets = list(example_sets(self.settings).values())
        told = {"seed": self.seed, "workers": self.workers, "progress": self.progress}
        simulate_examples(self.out / "examples", sets, **told)

    def _examples(self, *names: str) -> Examples:
        sets = example_sets(self.settings)
        return read_examples(self.out / "examples", *(sets[name] for name in names))

    def _see(self, backbone: FrozenBackbone, read_outs: DenseHeads, learned: Examples) -> Seen:
        validation = self._examples("validation")
        told = self.settings, self.seed, self.out, self.ranks.device, self.progress
        return train_to_see(backbone, read_outs, learned, validation, *told)

    def _finish(
        self, seen: Seen, speaker: Speaker, reader: Reader, seconds: Callable[[], float]
    ) -> None:
        """Calibrate, write the bundle, score what was written, and write its card."""
        provenance = _provenance(self.settings, self.seed, self.workers, self.ranks)
        provenance |= {"dgr_validation_accuracy": seen.accuracies}
        answers = load_templates().grammar()
        bundle = Bundle(
            seen.model, seen.motion, speaker, answers, Calibration(), provenance, reader
        )
        bundle.calibration = calibrated(bundle, seen.validation, self.seed)
        folder = self.out / "bundle"
        save_bundle(folder, bundle)
        # What is scored is what was written: half precision and all.
        stored = load_bundle(folder)
        test, mixed = (
            perceive_examples(stored.model, self._examples(name), self.progress)
            for name in ("test", "mixed")
        )
        scores = score_bundle(stored, test, self.seed)
        scores["mixed"] = motion_scores(stored.motion(mixed.measured), mixed.labels)
        scores["felt"] = felt_scores(stored, mixed)
        scores["felt by the fused token alone"] = felt_scores(stored, mixed, is_silent=True)
        write_card(folder, stored, scores, seconds())


def _provenance(settings: TrainingPreset, seed: int, workers: int, ranks: Ranks) -> dict[str, Any]:
    """Return how to get a bundle again, for the bundle itself."""
    launch = f"torchrun --nproc-per-node {ranks.count} -m geotlm_lm"
    program = "geotlm-lm" if ranks.count == 1 else launch
    command = f"{program} train --preset {settings.name} --seed {seed} --workers {workers}"
    return {
        "command": f"{command} --out RUN_FOLDER",
        "preset": settings.to_dict(),
        "seed": seed,
        "machine": machine(),
        "commit": commit(),
        "device": ranks.kind,
    }


def train_speaker(
    readings: Tensor,
    labels: Sequence[MotionLabel],
    settings: HeadsPreset,
    seed: int,
    out: Path,
    progress: Progress = silent,
    ranks: Ranks = ALONE,
) -> Speaker:
    """Train the language model on readings of clips (n, width) and their truth, within `out`."""
    config = LanguageTraining(
        steps=settings.language_steps,
        batch=settings.language_batch,
        motion_width=BELIEF_NUMBERS,
        seed=seed,
    )
    return train_language(
        readings,
        labels,
        config=config,
        folder=out / "language",
        ranks=ranks,
        progress=progress,
    )


def reader_of(
    settings: TrainingPreset,
    seed: int,
    folder: Path,
    progress: Progress = silent,
    ranks: Ranks = ALONE,
    workers: int = 0,
) -> Reader:
    """Train the reader of questions; the first rank's is calibrated on what it has not read.

    Where a GPU learns, `workers` processes draw the questions; on a CPU they would only wait for
    each other.
    """
    config = ReadingTraining(
        steps=settings.reading_steps,
        teachers=settings.reading_teachers,
        taught_steps=settings.taught_steps,
        batch=settings.reading_batch,
        seed=seed,
    )
    drawing = 0 if ranks.kind == "cpu" else workers
    reader = train_reader(config, folder, corpus("train"), progress, ranks, drawing)
    if not ranks.is_first:
        return reader
    held = [*islice(grammar().pairs(seed, "validation"), CALIBRATION_PAIRS), *corpus("validation")]
    questions = [Labelled(one.text, (one.query,)) for one in held]
    return calibrated_reader(reader, [*questions, *labelled(TUNE)])


CALIBRATION_PAIRS = 1500


def calibrated(bundle: Bundle, validation: ClipSet, seed: int) -> Calibration:
    """Fit temperature and contact threshold on clips that no weight has seen."""
    likelihoods, truths = true_option_likelihoods(bundle, validation, seed)
    is_touched = np.array([label.motion is not Motion.NONE for label in validation.labels])
    return Calibration(
        temperature=fit_temperature(likelihoods, truths),
        felt_temperature=fit_temperature(*felt_likelihoods(bundle, validation)),
        contact_threshold=fit_contact_threshold(validation.contact_share, is_touched),
    )
