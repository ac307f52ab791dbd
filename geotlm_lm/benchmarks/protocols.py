"""The paper's protocols on simulated clips of everyday objects, through one frozen backbone.

Five-fold and leave-one-object-out, with the paper's ablations; its own figures stand beside ours.
Each task runs in a process of its own.
"""

from __future__ import annotations

import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.tokens import Backbone, Tokens
from geotlm_lm.benchmarks import cases
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import share_row
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, GRID_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import mean_by_group, seed_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.dgr.ablations import DGRParts
from geotlm_lm.probe.curl import curl_features
from geotlm_lm.probe.linear import fit_logistic
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.runs.processes import one_thread
from geotlm_lm.runs.run import ALONE, Workers
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
from geotlm_lm.simulation.simulate import SimulatedClip, simulate_series
from geotlm_lm.training.examples import bin_means, truth_in_view
from geotlm_lm.training.folds import (
    Fold,
    Recipe,
    leave_one_object_out,
    object_folds,
    train_on_fold,
)
from geotlm_lm.training.geometry import TokenSet, halved

SEED = 42
"""Paper: training is seeded by 42 and the fold's number; a run's own seed is added."""

FOLD_COUNT, EPOCHS, CLIPS = 5, 30, 100
"""Paper: five folds, 30 epochs of every training; and readable clips of each object."""

DEALT: dict[str, Callable[[Sequence[str], int], list[Fold]]] = {
    "five-fold": lambda objects, seed: object_folds(objects, FOLD_COUNT, seed=seed),
    "leave-one-object-out": lambda objects, seed: leave_one_object_out(objects, seed=seed),
}
"""How clips are dealt into folds of three parts, no object in two of them."""

TASKS = ("rotation", "sliding")

ORDERS = {FRAME_COUNT: (0, 1, 2, 3), 2: (0, 0, 3, 3)}
"""Frames the backbone is given: all of them, or the first and the last, fed as a, a, b, b."""

ENCODE_BATCH = 8
"""Clips held in memory as pictures."""

FLOW = "optical flow + rigid fit"
CURL = "Curl + LR"
PLAIN, PLAIN_PAIR = "probe on c", "probe on c, 2 frames"
PAPER, PAPER_PAIR = "DGR, paper", "DGR, paper, 2 frames"
GROUNDED = "DGR, grounded"
NO_MASK = "DGR, region pool only"
NO_REGIONS = "DGR, contact mask only"
NEITHER = "DGR, neither"
OPERATORS = "DGR, differential operators on"

TRAINED: dict[str, tuple[Recipe, int]] = {
    PLAIN: (Recipe(), FRAME_COUNT),
    PAPER: (Recipe(DGRParts()), FRAME_COUNT),
    GROUNDED: (Recipe(DGRParts(), "grounded"), FRAME_COUNT),
    NEITHER: (Recipe(DGRParts(regions=False, mask=False)), FRAME_COUNT),
    NO_MASK: (Recipe(DGRParts(mask=False)), FRAME_COUNT),
    NO_REGIONS: (Recipe(DGRParts(regions=False)), FRAME_COUNT),
    OPERATORS: (Recipe(DGRParts(operators=True)), FRAME_COUNT),
    PLAIN_PAIR: (Recipe(), 2),
    PAPER_PAIR: (Recipe(DGRParts()), 2),
}
"""Methods that are trained on frozen tokens, and the frames that the backbone is given for them."""

MAIN = (CURL, FLOW, PLAIN, PAPER, GROUNDED)
ABLATION = (PLAIN, NEITHER, NO_MASK, NO_REGIONS, PAPER, OPERATORS)
FRAMES = (PLAIN_PAIR, PLAIN, PAPER_PAIR, PAPER)
OURS = tuple(dict.fromkeys(MAIN + ABLATION + FRAMES))
"""Methods of each table, in its order, and of all."""

Outcome = tuple[Sequence[Motion], int]
"""The motion that a method named for each test clip, and how many numbers it trained."""


@dataclass(frozen=True, eq=False)
class TaskClips:
    """One task's clips as tokens (by the number of frames), with their objects and motions.

    `flow` is the motions that optical flow and a rigid fit name, `curl` its features, (n, 5).
    """

    data: dict[int, TokenSet]
    objects: tuple[str, ...]
    truths: Sequence[Motion]
    flow: Sequence[Motion]
    curl: NDArray[np.float32]


def task_clips(
    backbone: Backbone, task: str, objects: Sequence[str], count: int, seed: int, progress: Progress
) -> TaskClips:
    """Simulate and encode `count` readable clips of each object in a task, batch by batch."""
    labels, flow, curl, among = [], [], [], cases.TASKS[task]
    parts: dict[int, list[TokenSet]] = {frames: [] for frames in ORDERS}
    for done, name in enumerate(objects):
        progress(f"paper's protocols, {task}: objects encoded", done, len(objects))
        for batch in _batches(task, name, count, seed):
            own = [made.label for made in batch]
            labels += own
            flow += [RigidFlow().predict(made.clip, among) for made in batch]
            curl += [curl_features(made.clip) for made in batch]
            for frames, order in ORDERS.items():
                tokens = halved(backbone.encode([made.clip.select(order) for made in batch]))
                truth = _truth(tokens, batch, order)
                parts[frames].append(TokenSet.of(tokens, own, *truth))
    names = tuple(name for name in objects for _ in range(count))
    data = {frames: TokenSet.joined(own) for frames, own in parts.items()}
    return TaskClips(data, names, [label.motion for label in labels], flow, np.stack(curl))


def _batches(task: str, name: str, count: int, seed: int) -> Iterator[list[SimulatedClip]]:
    """Yield an object's readable clips, so many at a time as are held in memory."""
    most, motions = cases.MOST_TRIES * count, cases.TASKS[task]
    seed = seed_for(seed, "protocols", task, name)
    series = simulate_series(seed, most, objects=(name,), motions=motions)
    readable = islice((made for made in series if made.label.is_readable), count)
    yielded = 0
    while batch := list(islice(readable, ENCODE_BATCH)):
        yielded += len(batch)
        yield batch
    if yielded < count:
        raise UsageError(
            f"{name}: {yielded} readable clips of {task} among {most} simulated ones, expected "
            f"{count}; ask for more clips, or leave the object out."
        )


def _truth(tokens: Tokens, batch: Sequence[SimulatedClip], order: Sequence[int]) -> list[Tensor]:
    """Return true shear change and contact on the tokens' grid; nothing where it is another one."""
    if tokens.patches.shape[2:4] != (GRID_SIDE, GRID_SIDE) or None in tokens.views:
        return []
    changes, contacts = [], []
    for view, made in zip(tokens.views, batch, strict=True):
        moved, contact, _ = (bin_means(values[list(order)]) for values in truth_in_view(view, made))
        changes.append(moved[1] - moved[0])
        contacts.append(contact.mean(axis=0))
    return [torch.from_numpy(np.stack(own)).float() for own in (changes, contacts)]


def methods_of(task: str, has_truth: bool) -> tuple[str, ...]:
    """Return the methods of a task: the curl tells turns only, the grounded one needs the truth."""
    left_out = [CURL] * (task != "rotation") + [GROUNDED] * (not has_truth)
    return tuple(name for name in OURS if name not in left_out)


def run_fold(
    clips: TaskClips, task: str, fold: Fold, methods: Sequence[str], *, epochs: int, seed: int
) -> dict[str, Outcome]:
    """Return the outcome of every method of a task on one fold."""
    labels, outcomes = cases.TASKS[task], {}
    for name in methods:
        if name == FLOW:  # named when the clip was at hand; nothing is trained
            outcomes[name] = [clips.flow[row] for row in fold.test], 0
        elif name == CURL:
            outcomes[name] = _curl(clips, fold, labels)
        else:
            recipe, frames = TRAINED[name]
            data = clips.data[frames]
            trained = train_on_fold(data, fold, labels, recipe, epochs=epochs, seed=seed)
            outcomes[name] = trained.predictions, trained.parameters
    return outcomes


def _curl(clips: TaskClips, fold: Fold, labels: tuple[Motion, ...]) -> Outcome:
    """Fit the logistic line on the training clips; there is no epoch to choose."""
    features = torch.from_numpy(clips.curl)
    standardiser = Standardiser.fit(features[fold.train])
    motions = [clips.truths[row] for row in fold.train]
    probe = fit_logistic(standardiser.apply(features[fold.train]), motions, labels)
    named = probe.predict(standardiser.apply(features[fold.test]))
    return named, sum(parameter.numel() for parameter in probe.parameters())


def fold_scores(
    clips: TaskClips, folds: Sequence[Fold], named: Sequence[Sequence[Motion]]
) -> tuple[NDArray[np.bool_], float, dict[str, Any]]:
    """Return what the paper's tables show of the motions that one method named, fold by fold.

    That is whether each clip was named right, the accuracy as mean over folds, `sd` (n - 1) of it,
    and `recall`, of each class the mean over the folds that hold it.
    """
    right, recalls = np.zeros(len(clips.truths), dtype=bool), defaultdict(list)
    for fold, motions in zip(folds, named, strict=True):
        truths = [clips.truths[row] for row in fold.test]
        right[fold.test] = [true == own for true, own in zip(truths, motions, strict=True)]
        for name, share in mean_by_group(right[fold.test], truths).items():
            recalls[str(name)].append(share)
    shares = [float(right[fold.test].mean()) for fold in folds]
    recall = {name: float(np.mean(own)) for name, own in recalls.items()}
    return right, float(np.mean(shares)), {"sd": float(np.std(shares, ddof=1)), "recall": recall}


def protocol_rows(run: Run) -> list[Row]:
    """Return the rows of both tasks and protocols, and the published ones."""
    # A model that was given is one object of this process; a quick run is not worth two starts.
    is_here = run.is_quick or run.answerer_given is not None
    workers = ALONE if is_here else Workers(len(TASKS))
    asked = run if is_here else replace(run, progress=silent)
    by_task = dict(workers.map(partial(task_rows, run=asked), TASKS))
    return [row for task in TASKS for row in (*by_task[task], *published_rows(task))]


def task_rows(task: str, run: Run) -> list[Row]:
    """Return one task's rows in both protocols, on one thread."""
    objects, seed = tuple(EVERYDAY_OBJECTS)[: run.size(None, FOLD_COUNT)], SEED + run.seed
    with one_thread():
        count = run.size(CLIPS, 2)
        if run.encoder is None:
            backbone = run.answerer.bundle.model.backbone
        else:
            from geotlm_lm.backbone.released import load_encoder

            given = load_encoder(run.encoder.weights, run.encoder.name, heads=run.encoder.heads)
            backbone = given.to("cuda" if torch.cuda.is_available() else "cpu")
        clips = task_clips(backbone, task, objects, count, seed, run.progress)
        return [row for name in DEALT for row in _rows(run, task, name, clips)]


def _rows(run: Run, task: str, protocol: str, clips: TaskClips) -> Iterator[Row]:
    case, seed, outcomes = f"{task}, {protocol}", SEED + run.seed, []
    methods = methods_of(task, clips.data[FRAME_COUNT].contact is not None)
    folds, epochs = DEALT[protocol](clips.objects, seed), run.size(EPOCHS, 1)
    for number, fold in enumerate(folds):
        run.progress(f"paper's protocols, {case}: folds", number, len(folds))
        outcomes.append(run_fold(clips, task, fold, methods, epochs=epochs, seed=seed + number))
    for name in methods:
        right, mean, detail = fold_scores(clips, folds, [own[name][0] for own in outcomes])
        detail["parameters"] = outcomes[0][name][1]
        yield replace(share_row(case, name, right, clips.objects), error=1 - mean, detail=detail)


def published_rows(task: str) -> Iterator[Row]:
    """Yield the paper's own figures of a task, marked as published."""
    published = tomllib.loads(Path(__file__).with_name("published.toml").read_text())
    for place, data in enumerate(published["data"]):
        for name, cells in published[task]["methods"].items():
            if cells[place]:
                mean, sd, *recall = cells[place]
                # The paper gives no recall by the number of frames.
                recalls = dict(zip(published[task]["classes"], recall, strict=bool(recall)))
                detail = {"sd": sd, "recall": recalls}
                yield Row(f"{task}, published: {data}", name, 0, 1 - mean, detail=detail)


def _recall(row: Row) -> str:
    recall = row.detail["recall"]
    return ", ".join(f"{way.value} {recall[way]:.3f}" for way in Motion if way in recall) or "-"


def _of(view: Pivot, methods: Sequence[str], task: str = "") -> Pivot:
    return replace(view, shows=lambda row: row.variant in methods and row.case.startswith(task))


_BY_METHOD = Pivot(
    lambda row: f"{row.right:.3f} ± {row.detail['sd']:.3f}", "task and clips", with_count=False
)

_TOGETHER = {
    "clips": "case",
    "method": "variant",
    "n": "count",
    "right (95 %, objects resampled)": right_with_interval,
    "trained numbers": "parameters:,",
}

PROTOCOLS = Section(
    name="protocols",
    title="The paper's protocols",
    about="""\
*Ours* are simulated clips of everyday objects that no weight of the backbone was trained on;
*published* are the paper's figures, on other data and through its own backbone. They share a
protocol, not data: a difference between the two says nothing about either. Mean accuracy and
standard deviation (n - 1) over folds. No object stands in two of a fold's three parts; the epoch is
chosen on the validation objects. *Probe on c* reads the global token alone: the paper's bare
backbone, AnyTouch 2. *DGR, paper* is the paper's GeoTLM; *grounded* is shaped by true displacement
and contact as well. *Curl + LR* takes the curl of the imprint's optical flow. *Region pool only*
weighs every patch alike; *contact mask only* keeps the weighted mean over the grid; *neither* is
the plain mean. Two frames are the first and the last of the same clip, fed as a, a, b, b.""",
    shares=whole(protocol_rows),
    views={
        "Rotation, ours and published": _of(_BY_METHOD, MAIN, "rotation"),
        "Sliding, ours and published": _of(_BY_METHOD, MAIN, "sliding"),
        "Parts of DGR taken out": _of(_BY_METHOD, ABLATION),
        "Two frames and four": _of(_BY_METHOD, FRAMES),
        "Encoders that only the paper has": replace(
            _BY_METHOD, shows=lambda row: row.variant not in OURS
        ),
        "Recall of each class": _of(replace(_BY_METHOD, cell=_recall), MAIN),
        "All clips together": Listing(_TOGETHER, lambda row: "parameters" in row.detail),
    },
)
