"""Make a whole bundle from nothing: simulate, pretrain, freeze, read geometry, learn to speak.

Every stage leaves its result in the run folder, so that an interrupted run continues where it was.
"""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from geotlm_lm.backbone.frozen import FrozenBackbone
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.checkpoint import Bundle, Calibration, load_bundle, reading_of, save_bundle
from geotlm_lm.core.atomic import write_text_atomically
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.record import commit, machine
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.generation import Speaker
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.network import BELIEF_NUMBERS, MotionNetwork
from geotlm_lm.query.grammar import corpus, grammar
from geotlm_lm.query.labelled import TUNE, Labelled, labelled
from geotlm_lm.query.reader import Reader
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.simulation.series import SERIES_VERSION
from geotlm_lm.training.calibration import fit_contact_threshold, fit_temperature
from geotlm_lm.training.card import write_card
from geotlm_lm.training.config import HeadsPreset, TrainingPreset, preset_named
from geotlm_lm.training.dense_targets import DenseHeads
from geotlm_lm.training.examples import (
    DAMAGED_SHARE,
    EXAMPLES_VERSION,
    VARIED,
    Examples,
    ExampleSet,
    read_examples,
    simulate_examples,
)
from geotlm_lm.training.geometry import (
    GeometryModel,
    better_mode,
    train_geometry,
    train_global_probe,
)
from geotlm_lm.training.language import LanguageTraining, train_language
from geotlm_lm.training.motion import motion_scores, train_motion, widen_spans
from geotlm_lm.training.perceiving import perceive_examples, token_set
from geotlm_lm.training.pretraining import PRETRAINING_VERSION, pretrain
from geotlm_lm.training.reading import ReadingTraining, calibrated_reader, train_reader
from geotlm_lm.training.run_clock import clock
from geotlm_lm.training.scoring import (
    ClipSet,
    felt_likelihoods,
    felt_scores,
    score_bundle,
    true_option_likelihoods,
)

RUN_FILE = "run.json"
VALIDATION_EVERY = 7
"""Every seventh training object is kept from all weights, for mode choice and calibration."""


def train(preset: str, out: Path, seed: int, workers: int, progress: Progress = silent) -> Path:
    """Train the bundle of `preset` and return its folder, `out`/bundle.

    Args:
        preset: Name of a preset.
        out: Run folder; a run of the same preset and seed in it is continued.
        seed: Root seed; on one machine, the same seed and workers give the same weights.
        workers: Processes that simulate, and threads that train.
        progress: Told how far it is.

    Raises:
        UsageError: If the preset is unknown or the folder holds another run.
    """
    settings = preset_named(preset)
    claim_folder(out, about_examples(settings, seed))
    torch.set_num_threads(max(workers, 1))
    cv2.setNumThreads(1)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    examples, sets = out / "examples", example_sets(settings)
    with clock(out) as seconds:
        simulate_examples(
            examples, list(sets.values()), seed=seed, workers=workers, progress=progress
        )
        learned = read_examples(examples, sets["heads"], sets["pretraining"])
        backbone, read_outs = pretrain(
            learned,
            preset=settings,
            seed=seed,
            device=device,
            folder=out,
            first=settings.fresh_clips,
            progress=progress,
        )
        validation = read_examples(examples, sets["validation"])
        model, modes = _train_perception(
            backbone, read_outs, learned, validation, settings, seed, out, progress
        )
        spoken_of = perceive_examples(model, learned, progress)
        del learned
        perceived = perceive_examples(model, validation, progress)
        motion = train_motion(spoken_of.measured, spoken_of.labels, seed=seed, progress=progress)
        widen_spans(motion, perceived.measured, perceived.labels)
        speaker = train_speaker(spoken_of, motion, settings, seed, out, progress)
        provenance = _provenance(settings, seed, workers)
        provenance |= {"device": device, "dgr_validation_accuracy": modes}
        answers = load_templates().grammar()
        reader = reader_of(settings, seed, out / "reader", progress)
        bundle = Bundle(model, motion, speaker, answers, Calibration(), provenance, reader)
        bundle.calibration = calibrated(bundle, perceived, seed)
        folder = out / "bundle"
        save_bundle(folder, bundle)
        # What is scored is what was written: half precision and all.
        stored = load_bundle(folder)
        test = perceive_examples(stored.model, read_examples(examples, sets["test"]), progress)
        scores = score_bundle(stored, test, seed)
        mixed = perceive_examples(stored.model, read_examples(examples, sets["mixed"]), progress)
        scores["mixed"] = motion_scores(stored.motion(mixed.measured), mixed.labels)
        scores["felt"] = felt_scores(stored, mixed)
        scores["felt by the fused token alone"] = felt_scores(stored, mixed, is_silent=True)
    write_card(folder, stored, scores, seconds())
    return folder


def _provenance(settings: TrainingPreset, seed: int, workers: int) -> dict[str, Any]:
    """Return how to get a bundle again, for the bundle itself."""
    command = f"geotlm-lm train --preset {settings.name} --seed {seed} --workers {workers}"
    return {
        "command": f"{command} --out RUN_FOLDER",
        "preset": settings.to_dict(),
        "seed": seed,
        "machine": machine(),
        "commit": commit(),
    }


def example_sets(settings: TrainingPreset) -> dict[str, ExampleSet]:
    """Return the five sets of a run by name.

    The objects of `validation` and of `test` are in no other set. Only `test` is the plain series,
    so that the card of one bundle compares with that of another.
    """
    kept = TRAINING_OBJECTS[::VALIDATION_EVERY]
    trained_on = tuple(name for name in TRAINING_OBJECTS if name not in kept)
    sets = (
        ExampleSet("pretraining", settings.pretraining_clips, trained_on),
        ExampleSet("heads", settings.head_clips, trained_on),
        ExampleSet("validation", settings.validation_clips, kept),
        ExampleSet("test", settings.test_clips, EVERYDAY_OBJECTS, is_varied=False),
        ExampleSet("mixed", settings.test_clips, EVERYDAY_OBJECTS, is_varied=False, is_mixed=True),
    )
    return {one.stage: one for one in sets}


def about_examples(settings: TrainingPreset, seed: int) -> dict[str, Any]:
    """Return what the examples of a run depend on."""
    about = {"preset": settings.to_dict(), "seed": seed}
    about |= {"series": SERIES_VERSION, "inputs": PATCH_INPUT_DIM, "worn": DAMAGED_SHARE}
    about |= {"examples": EXAMPLES_VERSION}
    return about | {"varied": VARIED, "pretraining": PRETRAINING_VERSION}


def claim_folder(out: Path, about: dict[str, Any]) -> None:
    """Mark `out` as the folder of the run that `about` describes.

    Raises:
        UsageError: If it holds another run.
    """
    path = out / RUN_FILE
    if path.exists() and json.loads(path.read_text()) != about:
        raise UsageError(
            f"{out} holds a run of another preset, seed or version of this program; give an empty "
            f"folder, or continue the run as it began."
        )
    write_text_atomically(path, json.dumps(about, indent=1) + "\n")


def _train_perception(
    backbone: FrozenBackbone,
    read_outs: DenseHeads,
    learned: Examples,
    validation: Examples,
    settings: TrainingPreset,
    seed: int,
    out: Path,
    progress: Progress,
) -> tuple[GeoTLM, dict[str, float]]:
    """Train DGR both ways and keep the one that answers better on validation objects.

    The drawn shear field of `paper` follows no true displacement, so that it has to be better.
    """
    train_set = token_set(backbone, learned, settings.fresh_clips, progress)
    validation_set = token_set(backbone, validation, len(validation), progress)
    trained: dict[str, GeometryModel] = {
        mode: train_geometry(
            train_set,
            validation_set,
            mode=mode,
            read_outs=read_outs,
            epochs=settings.geometry_epochs,
            seed=seed,
            path=out / f"dgr_{mode}.pt",
            progress=progress,
        )
        for mode in ("paper", "grounded")
    }
    accuracies = {mode: model.validation_accuracy for mode, model in trained.items()}
    chosen = trained[better_mode(accuracies)]
    global_probe = train_global_probe(
        train_set,
        validation_set,
        chosen.global_standardiser,
        epochs=settings.geometry_epochs,
        seed=seed,
    )
    model = GeoTLM(
        backbone=backbone,
        global_standardiser=chosen.global_standardiser,
        patch_standardiser=chosen.patch_standardiser,
        dgr=chosen.dgr.eval().requires_grad_(False),
        probe=chosen.probe.eval().requires_grad_(False),
        global_probe=global_probe.eval().requires_grad_(False),
    )
    return model, accuracies


def train_speaker(
    clips: ClipSet,
    motion: MotionNetwork,
    settings: HeadsPreset,
    seed: int,
    out: Path,
    progress: Progress = silent,
) -> Speaker:
    """Train the language model on `clips`, of which `motion` believes; checkpoint in `out`."""
    config = LanguageTraining(
        steps=settings.language_steps,
        batch=settings.language_batch,
        motion_width=BELIEF_NUMBERS,
        seed=seed,
    )
    return train_language(
        reading_of(clips.fused_tokens, motion(clips.measured)),
        clips.labels,
        config=config,
        folder=out / "language",
        progress=progress,
    )


def reader_of(
    settings: TrainingPreset, seed: int, folder: Path, progress: Progress = silent
) -> Reader:
    """Train the reader of questions and calibrate it on families and people it has not read."""
    config = ReadingTraining(steps=settings.reading_steps, batch=settings.reading_batch, seed=seed)
    reader = train_reader(config, folder, corpus("train"), progress)
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
