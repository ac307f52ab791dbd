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
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.record import commit, machine
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.measured import Measured, measured
from geotlm_lm.motion.network import BELIEF_NUMBERS, MotionNetwork
from geotlm_lm.query.grammar import corpus
from geotlm_lm.query.labelled import TUNE, labelled
from geotlm_lm.query.reader import Reader
from geotlm_lm.training import english
from geotlm_lm.training.calibration import (
    calibrated_reader,
    fit_contact_threshold,
    fit_temperature,
)
from geotlm_lm.training.config import (
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
from geotlm_lm.training.language import LanguageTraining, Taught, blank_reader, train_language
from geotlm_lm.training.motion import (
    motion_scores,
    set_significance,
    train_motion,
    widen_spans,
)
from geotlm_lm.training.pretraining import DenseHeads, pretrain
from geotlm_lm.training.ranks import Ranks, joined
from geotlm_lm.training.scoring import (
    ClipSet,
    felt_likelihoods,
    felt_scores,
    score_bundle,
    write_card,
)
from geotlm_lm.training.sentences import read_sentences, write_sentences

STARTS = ("language", "slots", "sentences")
"""Stages before which a bundle may be taken as it is."""

PER_CLIP = 16
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
        raise UsageError(f"There is no stage '{stage}'; choose one of {', '.join(STARTS)}.")
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
            run.language(seen, start, stage)
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
        given = self.settings, self.seed, self.out, self.ranks.device, self.progress
        return _see(*pretrained, learned, self.examples("validation"), *given)

    def taken(self, bundle: Bundle) -> Seen | None:
        """Return what sees in a bundle."""
        if not self.ranks.is_first:
            return None
        model, accuracies = bundle.model, bundle.provenance["dgr_validation_accuracy"]
        validation = perceive(model, self.examples("validation"), self.progress)
        return Seen(model, bundle.motion, accuracies, validation)

    def language(self, seen: Seen | None, start: Path | None, stage: str) -> None:
        """Train the language model into `out`/language, from `stage` on."""
        settings, out = self.settings, self.out
        width = self.ranks.from_first(lambda: seen.model.backbone.width)

        def written() -> None:
            save_bundle(out / "draft", seen.bundle(blank_reader(width), {"command": "train"}))
            write_sentences(
                out / "sentences",
                out / "draft",
                settings.answer_clips,
                PER_CLIP,
                self.seed,
                self.workers,
                self.progress,
            )

        self.ranks.from_first(written)
        config = LanguageTraining(
            english_steps=settings.english_steps,
            reading_steps=settings.reading_steps,
            slots_steps=settings.slots_steps,
            sentences_steps=settings.sentences_steps,
            batch=settings.language_batch,
            answers=settings.language_batch // 2,
            passes=settings.question_passes,
            seed=self.seed,
        )
        taught = Taught(
            corpus("train"),
            sentences=read_sentences(out / "sentences"),
            widths=(width, BELIEF_NUMBERS),
        )
        if stage == "language":
            texts = self.ranks.from_first(lambda: english.fetch(out / "english", self.progress))
            taught = replace(taught, passages=english.passages(texts))
        else:
            kept = ("english_steps", "reading_steps", "slots_steps")[: 1 + STARTS.index(stage)]
            config = replace(config, **dict.fromkeys(kept, 0))
            taught = replace(taught, start=start / LANGUAGE_DIR)
        # On a CPU processes that draw would only wait for each other.
        drawing = 0 if self.ranks.kind == "cpu" else self.workers
        train_language(config, taught, out, self.progress, self.ranks, drawing)


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


def _see(
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
    """Train DGR both ways, probes and motion, and perceive all clips with them."""
    model, accuracies = train_perception(
        backbone,
        token_set(backbone, learned, settings.fresh_clips, progress),
        token_set(backbone, validation, len(validation), progress),
        settings.geometry_epochs,
        read_outs=read_outs,
        seed=seed,
        out=out,
        device=device,
        progress=progress,
    )
    clips = perceive(model, learned, progress), perceive(model, validation, progress)
    return train_beliefs(model, accuracies, *clips, seed=seed, device=device, progress=progress)


def train_perception(
    backbone: Backbone,
    train_set: TokenSet,
    validation_set: TokenSet,
    epochs: int,
    *,
    read_outs: DenseHeads | None,
    seed: int,
    out: Path,
    device: str = "cpu",
    progress: Progress = silent,
) -> tuple[GeoTLM, dict[str, float]]:
    """Train DGR and keep the way of training it that answers better on validation objects.

    The drawn shear field of `paper` follows no true displacement, so that it has to be better.
    Without read-outs that a backbone was pretrained through, DGR is trained the paper's way alone.
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
    return model, accuracies


def train_beliefs(
    model: GeoTLM,
    accuracies: Mapping[str, float],
    learned: ClipSet,
    validation: ClipSet,
    *,
    seed: int,
    device: str = "cpu",
    progress: Progress = silent,
) -> Seen:
    """Train the motion network on perceived clips; others decide how wide its spans are."""
    shared = {"seed": seed, "device": device, "progress": progress}
    motion = train_motion(learned.measured, learned.labels, **shared)
    widen_spans(motion, validation.measured, validation.labels)
    set_significance(motion, validation.measured, validation.labels)
    return Seen(model, motion, accuracies, validation)


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


def perceive(
    model: GeoTLM,
    clips: Any,
    progress: Progress = silent,
    tokens_of: Callable[[slice], Tokens] | None = None,
) -> ClipSet:
    """Return tokens, contact share and what is measured of every clip.

    Clips are `Examples` or `heads.EncodedClips`. Without `tokens_of`, which returns the tokens of
    some rows, their inputs are encoded.
    """
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
        objects=clips.objects,
    )
