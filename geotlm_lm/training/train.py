"""Make a whole bundle from nothing: simulate, pretrain, freeze, read geometry, learn to speak.

Every stage leaves its result in the run folder, so that an interrupted run continues where it was.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch

from geotlm_lm.backbone.frozen import ENCODE_BATCH, FrozenBackbone
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.checkpoint import Bundle, Calibration, load_bundle, save_bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import machine, write_text_atomically
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.speak import Speaker
from geotlm_lm.model import GeoTLM
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.training.calibration import fit_contact_threshold, fit_temperature
from geotlm_lm.training.card import write_card
from geotlm_lm.training.config import TrainingPreset, preset_named
from geotlm_lm.training.examples import Examples, simulated_examples
from geotlm_lm.training.geometry import (
    ALL_MOTIONS,
    GeometryModel,
    TokenSet,
    train_geometry,
    train_global_probe,
)
from geotlm_lm.training.language import LanguageTraining, train_language
from geotlm_lm.training.pretraining import pretrain
from geotlm_lm.training.progress import Progress
from geotlm_lm.training.scoring import ClipSet, score_bundle, true_option_likelihoods

RUN_FILE = "run.json"
VALIDATION_EVERY = 7
"""Every seventh training object is kept from all weights, for mode choice and calibration."""


@dataclass(frozen=True)
class Sets:
    """The four sets of simulated examples; objects of `validation` and `test` are in no other."""

    pretraining: Examples
    heads: Examples
    validation: Examples
    test: Examples


def train(preset: str, out: Path, seed: int, workers: int) -> Path:
    """Train the bundle of `preset` and return its folder, `out`/bundle.

    Args:
        preset: Name of a preset.
        out: Run folder; a run of the same preset and seed in it is continued.
        seed: Root seed; on one machine the same seed gives the same weights.
        workers: Processes that simulate, and threads that train.

    Raises:
        UsageError: If the preset is unknown or the folder holds another run.
    """
    settings = preset_named(preset)
    started = time.monotonic()
    _claim(out, settings, seed)
    torch.set_num_threads(max(workers, 1))
    cv2.setNumThreads(1)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    sets = _simulate(out / "examples", settings, seed, workers)
    backbone = pretrain(sets.pretraining, preset=settings, seed=seed, device=device, folder=out)
    model, modes = _train_perception(backbone, sets, settings, seed, out)
    heads = perceive_examples(model, sets.heads)
    speaker = _train_speaker(heads, settings, seed, out)
    provenance = {
        "command": f"geotlm-lm train --preset {preset} --seed {seed}",
        "preset": settings.to_dict(),
        "seed": seed,
        "machine": machine(),
        "device": device,
        "dgr_validation_accuracy": modes,
    }
    bundle = Bundle(model, speaker, load_templates().grammar(), Calibration(), provenance)
    validation = perceive_examples(model, sets.validation)
    bundle.calibration = _calibrate(bundle, validation, seed)
    folder = out / "bundle"
    save_bundle(folder, bundle)
    # What is scored is what was written: half precision and all.
    stored = load_bundle(folder)
    test = perceive_examples(stored.model, sets.test)
    scores = score_bundle(stored, test, seed)
    seconds = time.monotonic() - started
    write_card(folder, stored, scores, seconds)
    return folder


def perceive_examples(model: GeoTLM, examples: Examples) -> ClipSet:
    """Return fused token, global token and contact share of every example."""
    fused, plain, contact = [], [], []
    progress = Progress("perceive", len(examples))
    for start in range(0, len(examples), ENCODE_BATCH):
        inputs = torch.from_numpy(examples.inputs[start : start + ENCODE_BATCH])
        perception = model.fuse(model.backbone.encode_inputs(inputs))
        fused.append(perception.fused_token)
        plain.append(perception.global_token)
        contact.append(perception.geometry.region_mass[:, -1])
        progress.show(min(start + ENCODE_BATCH, len(examples)))
    return ClipSet(
        fused_tokens=torch.cat(fused),
        global_tokens=torch.cat(plain),
        contact_share=torch.cat(contact).numpy(),
        labels=examples.labels,
        objects=examples.objects,
    )


def _claim(out: Path, settings: TrainingPreset, seed: int) -> None:
    """Mark `out` as the folder of this run, or refuse a folder of another."""
    path, about = out / RUN_FILE, {"preset": settings.to_dict(), "seed": seed}
    if path.exists() and json.loads(path.read_text()) != about:
        raise UsageError(
            f"{out} holds a run of another preset or seed; give an empty folder, or the same "
            f"preset and seed to continue it."
        )
    write_text_atomically(path, json.dumps(about, indent=1) + "\n")


def _simulate(folder: Path, settings: TrainingPreset, seed: int, workers: int) -> Sets:
    validation_objects = TRAINING_OBJECTS[::VALIDATION_EVERY]
    training_objects = tuple(set(TRAINING_OBJECTS) - set(validation_objects))
    training_objects = tuple(name for name in TRAINING_OBJECTS if name in training_objects)
    plan = {
        "pretraining": (settings.pretraining_clips, training_objects),
        "heads": (settings.head_clips, training_objects),
        "validation": (settings.validation_clips, validation_objects),
        "test": (settings.test_clips, EVERYDAY_OBJECTS),
    }
    return Sets(
        **{
            stage: simulated_examples(
                folder, stage, count, objects=objects, seed=seed, workers=workers
            )
            for stage, (count, objects) in plan.items()
        }
    )


def _train_perception(
    backbone: FrozenBackbone, sets: Sets, settings: TrainingPreset, seed: int, out: Path
) -> tuple[GeoTLM, dict[str, float]]:
    """Train DGR both ways and keep the one that answers better on validation objects."""
    train_set = _token_set(backbone, sets.heads, settings.geometry_clips)
    validation_set = _token_set(backbone, sets.validation, len(sets.validation))
    trained: dict[str, GeometryModel] = {
        mode: train_geometry(
            train_set,
            validation_set,
            mode=mode,
            epochs=settings.geometry_epochs,
            seed=seed,
            path=out / f"dgr_{mode}.pt",
        )
        for mode in ("paper", "grounded")
    }
    accuracies = {mode: model.validation_accuracy for mode, model in trained.items()}
    chosen = trained[max(accuracies, key=accuracies.get)]
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


def _token_set(backbone: FrozenBackbone, examples: Examples, count: int) -> TokenSet:
    """Encode the first `count` examples; tokens stay in half precision to fit in memory."""
    count = min(count, len(examples))
    parts, progress = [], Progress("encode", count)
    for start in range(0, count, ENCODE_BATCH):
        rows = slice(start, min(start + ENCODE_BATCH, count))
        tokens = backbone.encode_inputs(torch.from_numpy(examples.inputs[rows]))
        parts.append((tokens.global_token, tokens.patches.half()))
        progress.show(rows.stop)
    displacement = torch.from_numpy(examples.displacement_px[:count])
    labels = examples.labels[:count]
    return TokenSet(
        tokens=Tokens(*(torch.cat(column) for column in zip(*parts, strict=True))),
        shear_change=displacement[:, 1] - displacement[:, 0],
        contact=torch.from_numpy(examples.contact[:count]).float().mean(dim=1),
        motions=torch.tensor([ALL_MOTIONS.index(label.motion) for label in labels]),
        is_readable=torch.tensor([label.is_readable for label in labels]),
    )


def _train_speaker(heads: ClipSet, settings: TrainingPreset, seed: int, out: Path) -> Speaker:
    readable = [i for i, label in enumerate(heads.labels) if label.is_readable]
    progress = Progress("train language", settings.language_steps)
    return train_language(
        heads.fused_tokens[readable],
        [heads.labels[i] for i in readable],
        config=LanguageTraining(
            steps=settings.language_steps, batch=settings.language_batch, seed=seed
        ),
        folder=out / "language",
        progress=lambda step, _, loss: progress.show(step, f"loss {loss:.3f}"),
    )


def _calibrate(bundle: Bundle, validation: ClipSet, seed: int) -> Calibration:
    likelihoods, truths = true_option_likelihoods(bundle, validation, seed)
    is_touched = np.array([label.motion is not Motion.NONE for label in validation.labels])
    return Calibration(
        temperature=fit_temperature(likelihoods, truths),
        contact_threshold=fit_contact_threshold(validation.contact_share, is_touched),
    )
