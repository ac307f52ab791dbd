"""From a frozen backbone to what is seen of every clip: DGR, probes and motion, trained in turn."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from torch import Tensor

from geotlm_lm.backbone.vit import FrozenBackbone
from geotlm_lm.checkpoint import reading_of
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.progress import Progress
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.network import MotionNetwork
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.dense_targets import DenseHeads
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.geometry import (
    GeometryModel,
    better_mode,
    train_geometry,
    train_global_probe,
)
from geotlm_lm.training.motion import train_motion, widen_spans
from geotlm_lm.training.perceiving import perceive_examples, token_set
from geotlm_lm.training.scoring import ClipSet


@dataclass(frozen=True)
class Seen:
    """What a training has made of its backbone, and how it sees the clips.

    Args:
        model: Backbone, DGR and probes.
        motion: The network that believes.
        accuracies: Of each way of training DGR, on validation objects.
        learned: The clips that motion and language learn from.
        validation: The clips of objects that no weight has seen.
    """

    model: GeoTLM
    motion: MotionNetwork
    accuracies: dict[str, float]
    learned: ClipSet
    validation: ClipSet

    def readings(self) -> tuple[Tensor, tuple[MotionLabel, ...]]:
        """Return what the language model reads of the clips it learns from, and their truth."""
        told = self.motion(self.learned.measured)
        return reading_of(self.learned.fused_tokens, told), self.learned.labels


def train_to_see(
    backbone: FrozenBackbone,
    read_outs: DenseHeads,
    learned: Examples,
    validation: Examples,
    settings: TrainingPreset,
    seed: int,
    out: Path,
    device: str,
    progress: Progress,
) -> Seen:
    """Train DGR, probes and motion on a device, and perceive all clips with them.

    Args:
        backbone: The frozen encoder.
        read_outs: The linear maps that it was pretrained through.
        learned: Clips to learn from, first those that DGR may see.
        validation: Clips of other objects.
        settings: Sizes and lengths.
        seed: Root seed.
        out: Run folder, where the checkpoints of DGR lie.
        device: Where to train.
        progress: Told how far it is.
    """
    model, accuracies = _train_perception(
        backbone, read_outs, learned, validation, settings, seed, out, device, progress
    )
    spoken_of = perceive_examples(model, learned, progress)
    perceived = perceive_examples(model, validation, progress)
    motion = train_motion(
        spoken_of.measured, spoken_of.labels, seed=seed, device=device, progress=progress
    )
    widen_spans(motion, perceived.measured, perceived.labels)
    return Seen(model, motion, accuracies, spoken_of, perceived)


def _train_perception(
    backbone: FrozenBackbone,
    read_outs: DenseHeads,
    learned: Examples,
    validation: Examples,
    settings: TrainingPreset,
    seed: int,
    out: Path,
    device: str,
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
            device=device,
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
