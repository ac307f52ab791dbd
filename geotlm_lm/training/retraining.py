"""Retrain the odometer of a finished bundle, and keep everything else of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import torch

from geotlm_lm.checkpoint import load_bundle, save_bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.record import RunRecord, commit, machine
from geotlm_lm.training.card import SCORES_FILE, write_card
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.examples import read_examples, simulate_examples
from geotlm_lm.training.odometry import train_odometer, within_tolerance_share
from geotlm_lm.training.run_clock import clock
from geotlm_lm.training.scoring import score_bundle
from geotlm_lm.training.train import (
    about_examples,
    claim_folder,
    example_sets,
    perceive_examples,
)


def retrain_odometer(
    kept: Path, out: Path, seed: int, workers: int, progress: Progress = silent
) -> Path:
    """Train a bundle's odometer on its own tokens of new clips; return the new bundle's folder.

    The clips are those a training of the whole bundle would simulate.

    Args:
        kept: The bundle whose perception and language model are kept.
        out: Run folder, `out`/bundle the new bundle; an interrupted run is continued.
        seed: Root seed.
        workers: Processes that simulate, and threads that train.
        progress: Told how far it is.

    Raises:
        IncompatibleBundle: If `kept` holds no bundle of this format.
        UsageError: If it reads a released encoder, or `out` holds another run.
    """
    bundle = load_bundle(kept)
    try:
        settings = TrainingPreset.of(bundle.provenance["preset"])
    except (AttributeError, KeyError, TypeError) as error:
        raise UsageError(
            f"{kept} does not say by which preset it was trained, expected a bundle that "
            f"`geotlm-lm train` wrote; train a whole one without --keep."
        ) from error
    whole = RunRecord.load(kept / SCORES_FILE)
    claim_folder(out, about_examples(settings, seed) | {"kept": bundle.digest()})
    torch.set_num_threads(max(workers, 1))
    cv2.setNumThreads(1)
    examples, sets = out / "examples", example_sets(settings)
    wanted = [sets[name] for name in ("heads", "pretraining", "test")]
    with clock(out) as seconds:
        simulate_examples(examples, wanted, seed=seed, workers=workers, progress=progress)
        learned = perceive_examples(bundle.model, read_examples(examples, *wanted[:2]), progress)
        command = (
            f"geotlm-lm train --keep BUNDLE --seed {seed} --workers {workers} --out RUN_FOLDER"
        )
        odometer = train_odometer(learned, seed=seed, progress=progress)
        made = {"command": command, "seed": seed, "machine": machine(), "commit": commit()}
        made["seconds"] = round(seconds())
        bundle = replace(
            bundle, odometer=odometer, provenance=bundle.provenance | {"odometer": made}
        )
        folder = out / "bundle"
        save_bundle(folder, bundle)
        stored = load_bundle(folder)
        test = perceive_examples(stored.model, read_examples(examples, sets["test"]), progress)
        scores = score_bundle(stored, test, seed)
        scores["amounts"] = within_tolerance_share(stored.odometer, test)
    write_card(folder, stored, scores, whole.seconds)
    return folder
