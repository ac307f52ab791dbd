"""The folder of a training run: whose it is, and which examples lie in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.core.atomic import write_text_atomically
from geotlm_lm.core.errors import UsageError
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.simulation.simulate import SERIES_VERSION
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.examples import DAMAGED_SHARE, EXAMPLES_VERSION, VARIED, ExampleSet
from geotlm_lm.training.pretraining import PRETRAINING_VERSION

RUN_FILE = "run.json"
VALIDATION_EVERY = 7
"""Every seventh training object is kept from all weights, for mode choice and calibration."""


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


def claim_folder(
    out: Path,
    about: dict[str, Any],
    *,
    run: str = "another preset, seed or version of this program",
    advice: str = "give an empty folder",
) -> None:
    """Mark `out` as the folder of the run that `about` describes.

    Args:
        out: The folder.
        about: What decides the run.
        run: What another one is of.
        advice: What is said to do then, beside going on as it began.

    Raises:
        UsageError: If it holds another run.
    """
    path = out / RUN_FILE
    if path.exists() and json.loads(path.read_text()) != about:
        raise UsageError(f"{out} holds a run of {run}; {advice}, or continue the run as it began.")
    write_text_atomically(path, json.dumps(about, indent=1) + "\n")
