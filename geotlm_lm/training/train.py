"""Make a whole bundle from nothing: simulate, pretrain, freeze, read geometry, learn language.

Every stage leaves its result in the run folder, so that an interrupted run continues where it was,
on this machine or another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from geotlm_lm.backbone.tokens import Backbone, Tokens
from geotlm_lm.backbone.vit import ENCODE_BATCH, FrozenBackbone
from geotlm_lm.checkpoint import LANGUAGE_DIR, Bundle, Calibration, load_bundle, save_bundle
from geotlm_lm.core.errors import UsageError, choice_of
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.record import commit, machine
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.motion.measured import Measured, measured
from geotlm_lm.motion.network import MotionNetwork
from geotlm_lm.query.reader import Reader
from geotlm_lm.training import english
from geotlm_lm.training.calibration import (
    calibrated_reader,
    fit_contact_threshold,
    fit_temperature,
)
from geotlm_lm.training.config import (
    HeadsPreset,
    TrainingPreset,
    about_examples,
    claim_folder,
    clock,
    example_sets,
    preset_named,
)
from geotlm_lm.training.examples import Examples, read_examples, simulate_examples
from geotlm_lm.training.geometry import (
    TokenSet,
    better_mode,
    train_geometry,
    train_global_probe,
)
from geotlm_lm.training.grammar import corpus
from geotlm_lm.training.labelled import TUNE, labelled
from geotlm_lm.training.language import LanguageTraining, Taught, blank_reader, train_language
from geotlm_lm.training.motion import (
    motion_scores,
    set_significance,
    train_motion,
    widen_spans,
)
from geotlm_lm.training.pretraining import DenseHeads, pretrain
from geotlm_lm.training.ranks import ALONE, Ranks, joined
from geotlm_lm.training.scoring import (
    ClipSet,
    felt_likelihoods,
    felt_scores,
    score_bundle,
    write_card,
)
from geotlm_lm.training.sentences import read_sentences, write_sentences

STARTS = ("language", "reading", "slots", "sentences")
"""Stages before which a bundle may be taken as it is."""

PER_CLIP = 32
"""Questions asked about each clip that answers are written about."""


def train(
    preset: str,
    out: Path,
    seed: int,
    workers: int,
    progress: Progress = silent,
    device: str | None = None,
    start: Path | None = None,
    stage: str = "language",
) -> Path:
    """Train the bundle of `preset` and return its folder, `out`/bundle.

    What comes before `stage`, one of `STARTS`, may be taken from a bundle's folder.

    Of several processes that torchrun started, all take the steps of backbone and language model;
    the first one does what is left, writes and reports, and the others wait.

    A run of the same preset and seed in `out` is continued. On one machine the same seed and
    workers, which are processes that simulate and threads of each process that trains, give the
    same perception. The device is cpu or cuda, None for cuda where there is one.

    Raises:
        IncompatibleBundle: If there is no such bundle.
        UsageError: If the preset, stage or device is unknown, a batch does not divide among the
            processes or the folder holds another run.
        MissingDependency: If there are too few GPUs.
    """
    settings = preset_named(preset)
    if stage not in STARTS:
        raise UsageError(f"There is no stage '{stage}'; {choice_of(stage, STARTS)}")
    if start is None and stage != STARTS[0]:
        raise UsageError(f"--stage {stage} goes on from a bundle; give one by --start.")
    # Before hours of simulation: a folder that holds none is refused.
    given = None if start is None else load_bundle(start)
    torch.set_num_threads(max(workers, 1))
    cv2.setNumThreads(1)
    with joined(device) as ranks:
        ranks.refuse_uneven(settings.pretraining_batch, settings.language_batch)
        about = about_examples(settings, seed) | {"start": given and given.digest(), "stage": stage}
        ranks.from_first(lambda: claim_folder(out, about))
        progress = progress if ranks.is_first else silent
        run = _Run(settings, seed, out, workers, ranks, progress)
        with clock(out) if ranks.is_first else nullcontext(lambda: 0.0) as seconds:
            seen = run.perception() if given is None else run.taken(given)
            learn_language(seen, settings, seed, out, start, stage, workers, ranks, progress)
            if ranks.is_first:
                about = _provenance(settings, seed, workers, ranks, start, stage)
                reader = calibrated_reader(Reader.load(out / "language"), labelled(TUNE))
                save_bundle(out / "bundle", seen.bundle(reader, about))
                _score(out / "bundle", run.examples, seconds, progress)
            ranks.from_first(lambda: None)  # the others wait
    return out / "bundle"


@dataclass(frozen=True)
class _Run:
    """A training in a folder of its own."""

    settings: TrainingPreset
    seed: int
    out: Path
    workers: int
    ranks: Ranks
    progress: Progress

    def examples(self, *names: str) -> Examples:
        """Return sets of examples, one behind the other, simulated where they are not yet."""
        sets, folder = example_sets(self.settings), self.out / "examples"
        wanted = [sets[name] for name in names]
        shared = {"seed": self.seed, "workers": self.workers, "progress": self.progress}
        self.ranks.from_first(lambda: simulate_examples(folder, wanted, **shared))
        return read_examples(folder, *wanted)

    def perception(self) -> Seen | None:
        """Train what sees; the other ranks have none of it but the backbone."""
        learned = self.examples("heads", "pretraining")
        pretrained = pretrain(
            learned,
            preset=self.settings,
            seed=self.seed,
            folder=self.out,
            first=self.settings.fresh_clips,
            ranks=self.ranks,
            progress=self.progress,
        )
        if not self.ranks.is_first:
            return None
        (backbone, read_outs), validation = pretrained, self.examples("validation")
        fresh = self.settings.fresh_clips
        return learn_perception(
            backbone,
            learned,
            validation,
            token_set(backbone, learned, fresh, self.progress),
            token_set(backbone, validation, len(validation), self.progress),
            self.settings.geometry_epochs,
            read_outs=read_outs,
            seed=self.seed,
            out=self.out,
            device=self.ranks.device,
            progress=self.progress,
        )

    def taken(self, bundle: Bundle) -> Seen | None:
        """Return what sees in a bundle."""
        if not self.ranks.is_first:
            return None
        model, accuracies = bundle.model, bundle.provenance["dgr_validation_accuracy"]
        validation = perceive(model, self.examples("validation"), self.progress)
        return Seen(model, bundle.motion, accuracies, validation)


def learn_language(
    seen: Seen | None,
    settings: HeadsPreset,
    seed: int,
    out: Path,
    start: Path | None,
    stage: str,
    workers: int = 1,
    ranks: Ranks = ALONE,
    progress: Progress = silent,
) -> Path:
    """Train a language model from `stage` on, to answer from what is seen; return its folder.

    What comes before `stage` is that of the bundle in `start`; what reads already learns for three
    quarters of the steps. Only the first rank has `seen`.
    """
    width = ranks.from_first(lambda: seen.model.backbone.width)

    def written() -> None:
        draft = seen.bundle(blank_reader(width), {"command": "train"})
        if isinstance(seen.model.backbone, FrozenBackbone):  # others cannot be stored
            save_bundle(out / "draft", draft)
            draft = out / "draft"
        folder, clips = out / "sentences", settings.answer_clips
        write_sentences(folder, draft, clips, PER_CLIP, seed, workers, progress)

    ranks.from_first(written)
    config = LanguageTraining(
        english_steps=settings.english_steps,
        reading_steps=settings.reading_steps,
        slots_steps=settings.slots_steps,
        sentences_steps=settings.sentences_steps,
        batch=settings.language_batch,
        passes=settings.question_passes,
        seed=seed,
    )
    sentences, widths = read_sentences(out / "sentences"), (width, BELIEF_NUMBERS)
    taught = Taught(corpus("train"), sentences=sentences, widths=widths)
    if stage == STARTS[0]:
        texts = ranks.from_first(lambda: english.fetch(out / "english", progress))
        taught = replace(taught, passages=english.passages(texts))
    else:
        kept = ("english_steps", "reading_steps", "slots_steps")[: STARTS.index(stage)]
        config = replace(config, **dict.fromkeys(kept, 0))
        if stage == "reading":
            config = replace(config, reading_steps=3 * config.reading_steps // 4)
        taught = replace(taught, start=start / LANGUAGE_DIR)
    # On a CPU processes that draw would only wait for each other.
    drawing = 0 if ranks.kind == "cpu" else workers
    return train_language(config, taught, out, progress, ranks, drawing)


def _score(
    folder: Path,
    examples: Callable[[str], Examples],
    seconds: Callable[[], float],
    progress: Progress,
) -> None:
    """Score what was written, half precision and all, and write its card."""
    stored = load_bundle(folder)
    scores = score_bundle(stored, perceive(stored.model, examples("test"), progress))
    clips = perceive(stored.model, examples("mixed"), progress)
    scores["mixed"] = motion_scores(stored.motion(clips.measured), clips.labels)
    scores["gels"] = {
        title: _gel_scores(stored, examples(name), progress)
        for title, name in (("in training", "validation"), ("left out", "unseen gels"))
    }
    scores["felt"] = felt_scores(stored, clips)
    scores["felt by the fused token alone"] = felt_scores(stored, clips, is_silent=True)
    write_card(folder, stored, scores, seconds())


def _gel_scores(
    bundle: Bundle, examples: Examples, progress: Progress
) -> dict[str, dict[str, float]]:
    """Return `motion_scores` of all clips of a set, and of each kind of gel."""
    clips, gels = perceive(bundle.model, examples, progress), np.array(examples.gels)
    beliefs = bundle.motion(clips.measured)
    scores = {"all": motion_scores(beliefs, clips.labels)}
    for name in sorted(set(examples.gels)):
        rows = np.flatnonzero(gels == name)
        labels = [clips.labels[row] for row in rows]
        scores[name] = motion_scores(beliefs.only(torch.from_numpy(rows)), labels)
    return scores


def _provenance(
    settings: TrainingPreset,
    seed: int,
    workers: int,
    ranks: Ranks,
    start: Path | None,
    stage: str,
) -> dict[str, Any]:
    """Return how to get a bundle again, for the bundle itself."""
    launch = f"torchrun --nproc-per-node {ranks.count} -m geotlm_lm"
    program = "geotlm-lm" if ranks.count == 1 else launch
    command = f"{program} train --preset {settings.name} --seed {seed} --workers {workers}"
    command += "" if start is None else f" --start {start.name} --stage {stage}"
    return {
        "command": f"{command} --out RUN_FOLDER",
        "preset": asdict(settings),
        "seed": seed,
        "machine": machine(),
        "commit": commit(),
        "device": ranks.kind,
    }


@dataclass(frozen=True)
class Seen:
    """What a training has made of its backbone, and how it sees the clips."""

    model: GeoTLM
    motion: MotionNetwork  # the network whose beliefs everything is answered from
    accuracies: Mapping[str, float]  # of each way of training DGR, on validation objects
    validation: ClipSet  # the clips of objects that no weight has seen

    def bundle(self, reader: Reader, provenance: Mapping[str, Any]) -> Bundle:
        """Return the whole model, calibrated on clips that no weight has seen."""
        clips = self.validation
        about = dict(provenance) | {"dgr_validation_accuracy": dict(self.accuracies)}
        bundle = Bundle(self.model, self.motion, Calibration(), about, reader)
        is_touched = np.array([label.motion is not Motion.NONE for label in clips.labels])
        bundle.calibration = Calibration(
            felt_temperature=fit_temperature(*felt_likelihoods(bundle, clips)),
            contact_threshold=fit_contact_threshold(clips.contact_share, is_touched),
        )
        return bundle


def learn_perception(
    backbone: Backbone,
    learned: Any,
    validation: Any,
    train_set: TokenSet,
    validation_set: TokenSet,
    epochs: int,
    *,
    read_outs: DenseHeads | None = None,
    seed: int,
    out: Path,
    device: str = "cpu",
    progress: Progress = silent,
) -> Seen:
    """Train DGR, probes and motion on clips, `Examples` or `heads.EncodedClips`, and their tokens.

    Kept is the way of training DGR that answers better on validation objects: the drawn shear field
    of `paper` follows no true displacement, so that it has to be better. Without read-outs that a
    backbone was pretrained through, DGR is trained the paper's way alone. The validation clips also
    decide how wide the spans of beliefs are.
    """
    trained = {
        mode: train_geometry(
            train_set,
            validation_set,
            mode=mode,
            read_outs=read_outs,
            epochs=epochs,
            seed=seed,
            path=out / f"dgr_{mode}.pt",
            device=device,
            progress=progress,
        )
        for mode in (("paper",) if read_outs is None else ("paper", "grounded"))
    }
    accuracies = {mode: accuracy for mode, (_, accuracy) in trained.items()}
    chosen, _ = trained["paper" if read_outs is None else better_mode(accuracies)]
    global_probe = train_global_probe(train_set, validation_set, epochs=epochs, seed=seed)
    model = GeoTLM(
        backbone=backbone,
        global_standardiser=chosen.global_standardiser,
        patch_standardiser=chosen.patch_standardiser,
        dgr=chosen.dgr.eval().requires_grad_(False),
        probe=chosen.probe.eval().requires_grad_(False),
        global_probe=global_probe.eval().requires_grad_(False),
    )
    clips, kept = (perceive(model, part, progress) for part in (learned, validation))
    shared = {"seed": seed, "device": device, "progress": progress}
    motion = train_motion(clips.measured, clips.labels, **shared)
    widen_spans(motion, kept.measured, kept.labels)
    set_significance(motion, kept.measured, kept.labels)
    return Seen(model, motion, accuracies, kept)


def token_set(
    backbone: FrozenBackbone, examples: Examples, count: int, progress: Progress
) -> TokenSet:
    """Encode the first `count` examples; tokens stay in half precision to fit in memory."""
    count = min(count, len(examples))
    parts = []
    for start in range(0, count, ENCODE_BATCH):
        rows = slice(start, min(start + ENCODE_BATCH, count))
        tokens = backbone.encode_inputs(torch.from_numpy(examples.inputs[rows]))
        parts.append((tokens.global_token, tokens.patches.half()))
        progress("encode", rows.stop, count)
    displacement = torch.from_numpy(examples.displacement_px[:count])
    return TokenSet.of(
        Tokens(*(torch.cat(column) for column in zip(*parts, strict=True))),
        examples.labels[:count],
        shear_change=displacement[:, 1] - displacement[:, 0],
        contact=torch.from_numpy(examples.contact[:count]).float().mean(dim=1),
    )


def perceive(model: GeoTLM, clips: Any, progress: Progress = silent) -> ClipSet:
    """Return tokens, contact share and what is measured of every clip.

    Clips are `Examples`, whose inputs are encoded, or `heads.EncodedClips`, which have tokens.
    """
    tokens_of = getattr(clips, "tokens_of", None)
    fused, plain, contact, measurements = [], [], [], []
    for start in range(0, len(clips), ENCODE_BATCH):
        rows = slice(start, min(start + ENCODE_BATCH, len(clips)))
        inputs, motions = (torch.from_numpy(part[rows]) for part in (clips.inputs, clips.motions))
        tokens = tokens_of(rows) if tokens_of else model.backbone.encode_inputs(inputs)
        perception = model.fuse(tokens)
        fused.append(perception.fused_token)
        plain.append(perception.global_token)
        contact.append(perception.geometry.region_mass[:, -1])
        known = inputs, motions, perception.geometry, perception.fused_token
        measurements.append(measured(*known))
        progress("perceive", rows.stop, len(clips))
    return ClipSet(
        fused_tokens=torch.cat(fused),
        global_tokens=torch.cat(plain),
        contact_share=torch.cat(contact).numpy(),
        measured=Measured.joined(measurements),
        labels=clips.labels,
    )
