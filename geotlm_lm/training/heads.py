"""Train DGR, probe and language model on a released encoder; its own weights stay as they are.

The heads learn from simulated clips alone. DGR is trained the paper's way: no released encoder was
pretrained towards a displacement that its shear could start from.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.checkpoint import Bundle, Calibration, embedded_reader, reading_of
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.data.templates import load_templates
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.measured import Measured, measured
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.simulate import SERIES_VERSION
from geotlm_lm.training.config import HeadsPreset, heads_preset_named
from geotlm_lm.training.encoded_clips import EncodedClips, encode_examples
from geotlm_lm.training.examples import DAMAGED_SHARE, EXAMPLES_VERSION, VARIED, ExampleSet
from geotlm_lm.training.geometry import (
    ALL_MOTIONS,
    TokenSet,
    train_geometry,
    train_global_probe,
)
from geotlm_lm.training.motion import train_motion, widen_spans
from geotlm_lm.training.motion_loss import counts_motion
from geotlm_lm.training.run_folder import VALIDATION_EVERY, claim_folder
from geotlm_lm.training.scoring import ClipSet
from geotlm_lm.training.train import calibrated, train_speaker

if TYPE_CHECKING:
    from geotlm_lm.backbone.released import ReleasedEncoder

PERCEIVE_BATCH = 64


def train_heads(
    encoder: ReleasedEncoder, preset: str, out: Path, seed: int, progress: Progress = silent
) -> Bundle:
    """Return a model that sees through `encoder`; the heads' checkpoints are kept in `out`.

    Args:
        encoder: The encoder.
        preset: Name of a preset for heads.
        out: Run folder; a run of the same encoder, preset and seed in it is continued.
        seed: Root seed.
        progress: Told how far it is.

    Raises:
        UsageError: If the preset is unknown or the folder holds another run.
    """
    settings = heads_preset_named(preset)
    about = _claim(out, encoder, settings, seed)
    heads, validation = (
        encode_examples(encoder, out / "tokens", one, seed=seed, progress=progress)
        for one in _sets(settings)
    )
    model = _train_perception(encoder, heads, validation, settings, seed, out, progress)
    spoken_of = _perceived(model, heads)
    perceived = _perceived(model, validation)
    motion = train_motion(spoken_of.measured, spoken_of.labels, seed=seed, progress=progress)
    widen_spans(motion, perceived.measured, perceived.labels)
    readings = reading_of(spoken_of.fused_tokens, motion(spoken_of.measured))
    speaker = train_speaker(readings, spoken_of.labels, settings, seed, out, progress)
    grammar = load_templates().grammar()
    bundle = Bundle(model, motion, speaker, grammar, Calibration(), about, embedded_reader())
    bundle.calibration = calibrated(bundle, perceived, seed)
    return bundle


def _sets(settings: HeadsPreset) -> tuple[ExampleSet, ExampleSet]:
    """Return the clips to learn from and those to validate on, of other objects."""
    kept = TRAINING_OBJECTS[::VALIDATION_EVERY]
    learned = tuple(name for name in TRAINING_OBJECTS if name not in kept)
    return (
        ExampleSet("heads", settings.head_clips, learned),
        ExampleSet("validation", settings.validation_clips, kept),
    )


def _claim(out: Path, encoder: ReleasedEncoder, settings: HeadsPreset, seed: int) -> dict:
    """Mark `out` as the folder of this run and say what it is, or refuse a folder of another."""
    about = encoder.describe() | {"preset": settings.to_dict(), "seed": seed}
    about |= {"series": SERIES_VERSION, "varied": VARIED, "worn": DAMAGED_SHARE}
    about |= {"examples": EXAMPLES_VERSION}
    claim_folder(
        out,
        about,
        run="another encoder, preset, seed or version of this program",
        advice="give an empty folder by --run-folder",
    )
    return about


def _train_perception(
    encoder: ReleasedEncoder,
    heads: EncodedClips,
    validation: EncodedClips,
    settings: HeadsPreset,
    seed: int,
    out: Path,
    progress: Progress,
) -> GeoTLM:
    train_set, validation_set = _token_set(heads), _token_set(validation)
    epochs = settings.geometry_epochs
    trained = train_geometry(
        train_set,
        validation_set,
        mode="paper",
        read_outs=None,
        epochs=epochs,
        seed=seed,
        path=out / "dgr_paper.pt",
        progress=progress,
    )
    global_probe = train_global_probe(
        train_set, validation_set, trained.global_standardiser, epochs=epochs, seed=seed
    )
    return GeoTLM(
        backbone=encoder,
        global_standardiser=trained.global_standardiser,
        patch_standardiser=trained.patch_standardiser,
        dgr=trained.dgr.eval().requires_grad_(False),
        probe=trained.probe.eval().requires_grad_(False),
        global_probe=global_probe.eval().requires_grad_(False),
    )


def _token_set(clips: EncodedClips) -> TokenSet:
    return TokenSet(
        tokens=clips.tokens,
        shear_change=None,
        contact=None,
        motions=torch.tensor([ALL_MOTIONS.index(label.motion) for label in clips.labels]),
        is_readable=torch.tensor([label.is_readable for label in clips.labels]),
        counts_motion=torch.tensor([counts_motion(label) for label in clips.labels]),
    )


def _perceived(model: GeoTLM, clips: EncodedClips) -> ClipSet:
    """Return tokens, contact share and what is measured of every clip."""
    fused, plain, contact, found = [], [], [], []
    for start in range(0, len(clips), PERCEIVE_BATCH):
        rows = slice(start, start + PERCEIVE_BATCH)
        tokens = Tokens(clips.tokens.global_token[rows], clips.tokens.patches[rows].float())
        perception = model.fuse(tokens)
        fused.append(perception.fused_token)
        plain.append(perception.global_token)
        contact.append(perception.geometry.region_mass[:, -1])
        known = clips.inputs[rows], clips.motions[rows]
        found.append(measured(*known, perception.geometry, perception.fused_token))
    return ClipSet(
        fused_tokens=torch.cat(fused),
        global_tokens=torch.cat(plain),
        contact_share=torch.cat(contact).numpy(),
        measured=Measured.joined(found),
        labels=clips.labels,
        objects=clips.objects,
    )
