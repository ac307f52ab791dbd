"""Every setting that shapes a bundle, in three presets, and the folder that a run of one owns."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.core.errors import UsageError, choice_of
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.simulation.gels import HELD_OUT_GELS, TRAINING_GELS
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.simulation.simulate import SERIES_VERSION
from geotlm_lm.training.examples import DAMAGED_SHARE, EXAMPLES_VERSION, VARIED, ExampleSet

PRETRAINING_VERSION = 5
"""Raised when the backbone is shown or asked other things: no older run is continued."""

VALIDATION_EVERY = 7
"""Every seventh training object is kept from all weights, for mode choice and calibration."""

DGRMode = Literal["paper", "grounded"]
Preset = TypeVar("Preset", bound="HeadsPreset")


@dataclass(frozen=True, kw_only=True)
class HeadsPreset:
    """Sizes and lengths of training DGR, probe and language model on a frozen encoder.

    The paper trains DGR and probe for 30 epochs. Validation clips are of objects that no weight
    sees: best epoch, mode and calibration are chosen on them.
    """

    name: str
    head_clips: int
    validation_clips: int
    geometry_epochs: int
    # Clips that answers are written about, and steps in which the language model learns what is
    # felt in them, and to tell the answers.
    answer_clips: int
    slots_steps: int
    sentences_steps: int
    language_batch: int  # questions a step; half as many answers about clips
    english_steps: int = 0  # steps in which the language model learns English
    reading_steps: int = 0  # steps in which it learns what questions mean
    question_passes: int = 1  # how often each question that is drawn is learned from


@dataclass(frozen=True, kw_only=True)
class TrainingPreset(HeadsPreset):
    """Sizes and lengths of one training run from nothing: heads on an encoder of its own."""

    # Clips of the same objects as the head clips, on which the backbone is pretrained.
    pretraining_clips: int
    test_clips: int  # clips of everyday objects, scored once for the model card
    backbone_width: int  # width d of a token
    backbone_depth: int
    backbone_heads: int
    pretraining_draws: int  # clips drawn during pretraining, repeats counted
    pretraining_batch: int
    # How many of the head clips DGR and probe learn from; no backbone has seen them, whereas it
    # is pretrained on the others as well.
    geometry_clips: int

    @property
    def fresh_clips(self) -> int:
        """How many head clips, the first ones, no backbone has seen when DGR learns from them."""
        return min(self.geometry_clips, self.head_clips)


DEFAULT = TrainingPreset(
    name="default",
    english_steps=2_000,
    reading_steps=7_000,
    question_passes=2,
    answer_clips=6_144,
    slots_steps=2_000,
    sentences_steps=3_000,
    pretraining_clips=32_000,
    head_clips=16_000,
    validation_clips=2_000,
    test_clips=1_000,
    backbone_width=160,
    backbone_depth=2,
    backbone_heads=4,
    pretraining_draws=320_000,
    pretraining_batch=32,
    geometry_epochs=30,
    geometry_clips=8_000,
    language_batch=128,
)

FULL = replace(
    DEFAULT,
    name="full",
    english_steps=4_000,
    reading_steps=9_000,
    language_batch=512,
)
"""`default` with a larger language model, which takes a GPU twenty minutes."""

SMOKE = replace(
    DEFAULT,
    name="smoke",
    english_steps=10,
    reading_steps=20,
    answer_clips=24,
    slots_steps=10,
    sentences_steps=10,
    pretraining_clips=400,
    head_clips=300,
    validation_clips=100,
    test_clips=100,
    backbone_width=64,
    backbone_heads=1,
    pretraining_draws=800,
    geometry_epochs=3,
    geometry_clips=300,
    language_batch=32,
)

HEADS_DEFAULT = HeadsPreset(
    name="default",
    head_clips=3_000,
    validation_clips=500,
    geometry_epochs=30,
    answer_clips=2_048,
    slots_steps=1_000,
    sentences_steps=600,
    language_batch=128,
)

HEADS_SMOKE = HeadsPreset(
    name="smoke",
    head_clips=80,
    validation_clips=40,
    geometry_epochs=3,
    answer_clips=24,
    slots_steps=10,
    sentences_steps=10,
    language_batch=64,
)

PRESETS = {preset.name: preset for preset in (SMOKE, DEFAULT, FULL)}
HEADS_PRESETS = {preset.name: preset for preset in (HEADS_SMOKE, HEADS_DEFAULT)}


def preset_named(name: str, presets: dict[str, Preset] = PRESETS) -> Preset:
    """Return the preset called `name`, or raise a UsageError that lists them."""
    if name not in presets:
        raise UsageError(f"there is no preset '{name}'; {choice_of(name, presets)}")
    return presets[name]


def example_sets(settings: HeadsPreset) -> dict[str, ExampleSet]:
    """Return the sets of a run by name: six, or the two that heads alone need.

    The objects of `validation` and of `test` are in no set that is trained on. `unseen gels` is on
    kinds of gel that no other set has, with validation's objects, and nothing is chosen by it.
    Only `test` and `mixed` are the plain series, so that the card of one bundle compares with that
    of another.
    """
    kept = TRAINING_OBJECTS[::VALIDATION_EVERY]
    trained_on = tuple(name for name in TRAINING_OBJECTS if name not in kept)
    sets = [
        ExampleSet("heads", settings.head_clips, trained_on),
        ExampleSet("validation", settings.validation_clips, kept),
    ]
    if isinstance(settings, TrainingPreset):
        plain = {"count": settings.test_clips, "objects": EVERYDAY_OBJECTS, "is_varied": False}
        sets = [
            ExampleSet("pretraining", settings.pretraining_clips, trained_on),
            *sets,
            ExampleSet("test", **plain),
            ExampleSet("mixed", **plain, is_mixed=True),
            ExampleSet("unseen gels", settings.validation_clips, kept, is_held_out=True),
        ]
    return {wanted.stage: wanted for wanted in sets}


def about_examples(settings: HeadsPreset, seed: int) -> dict[str, Any]:
    """Return what the examples of a run depend on."""
    about = {"preset": asdict(settings), "seed": seed, "series": SERIES_VERSION}
    about |= {"varied": VARIED, "worn": DAMAGED_SHARE, "examples": EXAMPLES_VERSION}
    about |= {"gels": TRAINING_GELS, "unseen gels": HELD_OUT_GELS}
    if isinstance(settings, TrainingPreset):
        about |= {"inputs": PATCH_INPUT_DIM, "pretraining": PRETRAINING_VERSION}
    return about


def claim_folder(
    out: Path,
    about: dict[str, Any],
    *,
    run: str = "another preset, seed or version of this program",
    advice: str = "give an empty folder",
) -> None:
    """Mark `out` as the folder of the run that `about` describes.

    Raises:
        UsageError: If it holds another run, in the words of `run` and `advice`.
    """
    path = out / "run.json"
    if path.exists() and json.loads(path.read_text()) != about:
        raise UsageError(f"{out} holds a run of {run}; {advice}, or continue the run as it began.")
    write_text_atomically(path, json.dumps(about, indent=1) + "\n")


@contextmanager
def clock(out: Path) -> Iterator[Callable[[], float]]:
    """Give the seconds this run has taken, those before an interruption included."""
    path, started = out / "seconds.txt", time.monotonic()
    before = float(path.read_text()) if path.exists() else 0.0

    def seconds() -> float:
        return before + time.monotonic() - started

    try:
        yield seconds
    finally:
        write_text_atomically(path, f"{seconds():.1f}\n")
