"""Every setting that shapes a bundle, in three presets."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, TypeVar

from geotlm_lm.core.errors import UsageError

DGRMode = Literal["paper", "grounded"]
Preset = TypeVar("Preset", bound="HeadsPreset")


@dataclass(frozen=True, kw_only=True)
class HeadsPreset:
    """Sizes and lengths of training DGR, probe and language model on a frozen encoder.

    Args:
        name: Name of the preset.
        head_clips: Simulated clips the heads learn from.
        validation_clips: Clips of objects that no weight sees: best epoch, mode, calibration.
        geometry_epochs: Epochs of DGR and probe (paper: 30).
        language_steps: Steps of the language model.
        language_batch: Questions per step.
    """

    name: str
    head_clips: int
    validation_clips: int
    geometry_epochs: int
    language_steps: int
    language_batch: int

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return asdict(self)


@dataclass(frozen=True, kw_only=True)
class TrainingPreset(HeadsPreset):
    """Sizes and lengths of one training run from nothing: heads on an encoder of its own.

    Args:
        reading_steps: Steps of a reader of questions that learns from labels.
        reading_teachers: How many of these teach the one that is stored; 0 stores the first.
        taught_steps: Steps of the one that they teach.
        reading_batch: Questions per step.
        pretraining_clips: Simulated clips of the same objects as the head clips, on which the
            backbone is pretrained; the language model learns from them too.
        test_clips: Clips of everyday objects, scored once for the model card.
        backbone_width: Width d of a token.
        backbone_depth: Transformer blocks.
        backbone_heads: Attention heads.
        pretraining_draws: Clips drawn during pretraining, repeats counted.
        pretraining_batch: Clips per step.
        geometry_clips: How many of the head clips DGR and probe learn from; no backbone has seen
            them, whereas it is pretrained on the others as well.
    """

    reading_steps: int
    reading_teachers: int
    taught_steps: int
    reading_batch: int
    pretraining_clips: int
    test_clips: int
    backbone_width: int
    backbone_depth: int
    backbone_heads: int
    pretraining_draws: int
    pretraining_batch: int
    geometry_clips: int

    @property
    def fresh_clips(self) -> int:
        """How many head clips, the first ones, no backbone has seen when DGR learns from them."""
        return min(self.geometry_clips, self.head_clips)


DEFAULT = TrainingPreset(
    name="default",
    reading_steps=7_000,
    reading_teachers=0,
    taught_steps=0,
    reading_batch=128,
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
    language_steps=3_000,
    language_batch=64,
)

FULL = replace(
    DEFAULT,
    name="full",
    reading_steps=11_000,
    reading_teachers=3,
    taught_steps=3_500,
    reading_batch=512,
)
"""`default` with a reader like the shipped one, which takes a GPU half an hour."""

SMOKE = replace(
    DEFAULT,
    name="smoke",
    reading_steps=20,
    reading_teachers=0,
    taught_steps=0,
    reading_batch=32,
    pretraining_clips=400,
    head_clips=300,
    validation_clips=100,
    test_clips=100,
    backbone_width=64,
    backbone_depth=2,
    backbone_heads=1,
    pretraining_draws=800,
    geometry_epochs=3,
    geometry_clips=300,
    language_steps=60,
    language_batch=32,
)

HEADS_DEFAULT = HeadsPreset(
    name="default",
    head_clips=3_000,
    validation_clips=500,
    geometry_epochs=30,
    language_steps=4_000,
    language_batch=64,
)

HEADS_SMOKE = HeadsPreset(
    name="smoke",
    head_clips=80,
    validation_clips=40,
    geometry_epochs=3,
    language_steps=60,
    language_batch=32,
)

PRESETS = {preset.name: preset for preset in (SMOKE, DEFAULT, FULL)}
HEADS_PRESETS = {preset.name: preset for preset in (HEADS_SMOKE, HEADS_DEFAULT)}


def preset_named(name: str) -> TrainingPreset:
    """Return the preset for a whole bundle called `name`.

    Raises:
        UsageError: If there is none.
    """
    return _named(name, PRESETS)


def heads_preset_named(name: str) -> HeadsPreset:
    """Return the preset for heads called `name`.

    Raises:
        UsageError: If there is none.
    """
    return _named(name, HEADS_PRESETS)


def _named(name: str, presets: dict[str, Preset]) -> Preset:
    if name not in presets:
        raise UsageError(f"there is no preset '{name}'; choose one of {', '.join(presets)}.")
    return presets[name]
