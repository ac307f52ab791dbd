"""Simulated clips as training examples: patch inputs beside the simulator's dense truth.

Clips are simulated, turned into patch inputs and written in chunks by worker processes; a run that
was killed continues with the first missing chunk. Images are not kept.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE, TIME_BIN_COUNT
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.core.threads import one_thread_in_children
from geotlm_lm.training.interrupts import (
    children_end_with_it,
    deaf_children,
    end_if_orphaned,
)
from geotlm_lm.training.progress import Progress

if TYPE_CHECKING:
    from geotlm_lm.backbone.stem import View
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.simulation.simulate import SimulatedClip

CHUNK_CLIPS = 250

PAIR_SHARE = 0.25
"""Share of clips fed as two frames a, a, b, b, the way a frame pair is fed to four frames."""

UNKNOWN_BACKGROUND_SHARE = 0.3
"""Share of clips whose idle gel is estimated from the clip, as for a recording without one."""

MIRRORED_SHARE = 0.15
"""Share of clips flipped left to right, label and all: optics with a mirror in them."""

MOTIONS = (*Motion, *ROTATIONS)
"""What is drawn from: turns twice, so that a clip turns as often as it slides. With two turns among
ten motions a doubtful turn of a round body was taken for a slide (turns right 0.84, slides 0.97 on
577 simulated lids, knobs and the like)."""

MARKER_SHARE = 0.15
"""Share of training clips on a gel with markers."""

UNSTEADY_SHARE = 0.5
"""Share of training clips made by an unsteady hand."""

_ARRAYS = ("inputs", "displacement_px", "contact", "depth_mm")


@dataclass(frozen=True, eq=False)
class Examples:
    """A set of examples; arrays share their first axis.

    Args:
        inputs: Patch inputs, float16, shape (n, 2, 14, 14, dim).
        displacement_px: True displacement since the first frame, mean per time-bin, float16,
            shape (n, 2, 14, 14, 2), pixels of the square image.
        contact: Share of each patch in contact per time-bin, float16, shape (n, 2, 14, 14).
        depth_mm: Mean indentation per time-bin, float16, shape (n, 2, 14, 14).
        labels: The truth of each clip.
        objects: Name of the touched object of each clip.
    """

    inputs: NDArray[np.float16]
    displacement_px: NDArray[np.float16]
    contact: NDArray[np.float16]
    depth_mm: NDArray[np.float16]
    labels: tuple[MotionLabel, ...]
    objects: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.labels)


@dataclass(frozen=True)
class ExampleSet:
    """Which examples a set holds.

    Args:
        stage: Name of the set; with the seed it decides every clip.
        count: Number of examples; whole chunks are simulated.
        objects: Names of the objects to touch.
        is_varied: Whether it holds markers and unsteady hands, as training does, or is the plain
            series that evaluations use.
    """

    stage: str
    count: int
    objects: tuple[str, ...]
    is_varied: bool = True

    def simulated(self, stage_seed: int, first_index: int, count: int) -> Iterator[SimulatedClip]:
        """Yield clips `first_index` .. of the set, each made when it is asked for."""
        from geotlm_lm.simulation.series import simulate_series

        return simulate_series(
            stage_seed,
            count,
            objects=self.objects,
            first_index=first_index,
            motions=MOTIONS,
            marker_share=MARKER_SHARE if self.is_varied else 0.0,
            unsteady_share=UNSTEADY_SHARE if self.is_varied else 0.0,
        )

    def chunk_paths(self, folder: Path) -> list[Path]:
        """Return the files in `folder` that hold the set."""
        chunk_count = -(-self.count // CHUNK_CLIPS)
        return [folder / f"{self.stage}_{index:04d}.npz" for index in range(chunk_count)]


def simulate_examples(folder: Path, sets: Sequence[ExampleSet], *, seed: int, workers: int) -> None:
    """Simulate the chunks of `sets` that are not yet in `folder`.

    Ctrl-C ends the workers at once; finished chunks are kept.

    Args:
        folder: Where the chunks lie.
        sets: What to simulate.
        seed: Root seed.
        workers: Processes; the examples do not depend on it.
    """
    jobs, chunk_count = [], 0
    for one in sets:
        paths = one.chunk_paths(folder)
        chunk_count += len(paths)
        jobs += [(path, one, index, seed) for index, path in enumerate(paths) if not path.exists()]
    if not jobs:
        return
    folder.mkdir(parents=True, exist_ok=True)
    done = chunk_count - len(jobs)
    progress = Progress("simulate", chunk_count, done)
    # Spawned, not forked: a forked child may inherit locked thread pools.
    pool = ProcessPoolExecutor(max(workers, 1), mp_context=get_context("spawn"))
    with pool, children_end_with_it():
        with deaf_children(), one_thread_in_children():
            written = pool.map(_write_chunk, jobs)
        for _ in written:
            done += 1
            progress.show(done, f"chunks of {CHUNK_CLIPS} clips")


def read_examples(folder: Path, wanted: ExampleSet) -> Examples:
    """Read a set that `simulate_examples` wrote.

    Raises:
        UsageError: If the clips touch other objects than wanted, so that two sets might share one.
    """
    parts = [_read_chunk(path) for path in wanted.chunk_paths(folder)]
    examples = _first(_concatenate(parts), wanted.count)
    strangers = sorted(set(examples.objects) - set(wanted.objects))
    if strangers:
        raise UsageError(
            f"{folder}: the {wanted.stage} clips touch {', '.join(strangers)}, expected only "
            f"objects of that set; delete the folder to simulate them again."
        )
    return examples


def _write_chunk(job: tuple[Path, ExampleSet, int, int]) -> None:
    import cv2
    import torch

    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    path, wanted, chunk, seed = job
    first = chunk * CHUNK_CLIPS
    stage_seed = int(generator_for(seed, "examples", wanted.stage).integers(2**62))
    arrays: dict[str, list] = {name: [] for name in _ARRAYS}
    about = []
    clips = wanted.simulated(stage_seed, first, CHUNK_CLIPS)
    for index, simulated in enumerate(clips, start=first):
        rng = generator_for(stage_seed, "form", index)
        recorded = as_recorded(simulated, rng)
        for name, values in zip(_ARRAYS, _example(recorded), strict=True):
            arrays[name].append(values)
        about.append([simulated.object_name, recorded.label.to_dict()])
        end_if_orphaned()
    stacked = {name: np.stack(values).astype(np.float16) for name, values in arrays.items()}
    with replacing(path) as stream:
        np.savez(stream, about=np.array(json.dumps(about)), **stacked)


@dataclass(frozen=True, eq=False)
class Recorded:
    """A simulated clip the way a recording may come.

    Args:
        clip: Its four frames, the background known or estimated.
        label: What happens until the last of them.
        order: Which of the simulated frames they are.
        truth: What was simulated, in the same image.
    """

    clip: Clip
    label: MotionLabel
    order: list[int]
    truth: SimulatedClip


def as_recorded(simulated: SimulatedClip, rng: np.random.Generator) -> Recorded:
    """Draw a clip's form: all frames or a pair, through a mirror or not, an idle frame or none."""
    from dataclasses import replace

    from geotlm_lm.recordings.idle import estimate_background

    order = _frame_order(rng)
    is_mirrored = rng.random() < MIRRORED_SHARE
    label = simulated.label_until(max(order))
    simulated = mirrored(simulated) if is_mirrored else simulated
    clip = simulated.clip.select(order)
    if rng.random() < UNKNOWN_BACKGROUND_SHARE:
        clip = replace(clip, background=estimate_background(clip.frames))
    return Recorded(clip, label.mirrored() if is_mirrored else label, order, simulated)


def _example(recorded: Recorded) -> tuple[NDArray, ...]:
    """Return the arrays of one example, in the order of `_ARRAYS`."""
    from geotlm_lm.backbone.stem import look

    inputs, view = look(recorded.clip)
    truth = truth_in(view, recorded.truth)
    return inputs, *(bin_means(values[recorded.order]) for values in truth)


def mirrored(simulated: SimulatedClip) -> SimulatedClip:
    """Return what a camera behind a mirror records, and the dense truth in its image.

    The scene and its label stay those of the object; `MotionLabel.mirrored` flips the words.
    """
    from dataclasses import replace

    clip = simulated.clip
    flipped = np.ascontiguousarray(clip.frames[:, :, ::-1])
    background = np.ascontiguousarray(clip.background[:, ::-1])
    displacement = simulated.displacement_px[:, :, ::-1] * np.array([-1, 1], np.float32)
    drift = simulated.drift_px
    return replace(
        simulated,
        clip=replace(clip, frames=flipped, background=background),
        displacement_px=displacement,
        contact=simulated.contact[:, :, ::-1],
        depth_mm=simulated.depth_mm[:, :, ::-1],
        drift_px=None if drift is None else drift[:, :, ::-1] * np.array([-1, 1], np.float32),
    )


def truth_in(view: View, simulated: SimulatedClip) -> tuple[NDArray, NDArray, NDArray]:
    """Return displacement, contact and depth of every frame on the view's grid."""
    contact = np.stack([view.cut(frame) for frame in simulated.contact])
    depth = np.stack([view.cut(frame) for frame in simulated.depth_mm])
    # Patches without contact hold no displacement: they must not blend into their neighbours.
    touched = (simulated.contact > 0).astype(np.float32)
    weight = np.stack([view.cut(frame) for frame in touched])
    moved = np.stack([view.cut(frame) for frame in simulated.displacement_px])
    moved = moved / np.maximum(weight, 1e-3)[..., None] * (IMAGE_SIDE / view.side_px)
    return moved * (weight > 0.25)[..., None], contact, depth


def _frame_order(rng: np.random.Generator) -> list[int]:
    """Choose the four frames: all of them, or a pair one or two frames apart.

    A pair starts at the first frame because the truth's displacement counts from there. Farther
    apart, a turn of 40 degrees in one step is beyond any flow, and not a frame pair of a recording.
    """
    if rng.random() >= PAIR_SHARE:
        return list(range(FRAME_COUNT))
    last = int(rng.integers(1, FRAME_COUNT - 1))
    return [0, 0, last, last]


def bin_means(values: NDArray) -> NDArray:
    """Return the mean of each time-bin's frames: (4, ...) to (2, ...)."""
    return values.reshape(TIME_BIN_COUNT, -1, *values.shape[1:]).mean(axis=1)


def _read_chunk(path: Path) -> Examples:
    with np.load(path, allow_pickle=False) as stored:
        about = json.loads(str(stored["about"]))
        return Examples(
            **{name: stored[name] for name in _ARRAYS},
            labels=tuple(MotionLabel.from_dict(label) for _, label in about),
            objects=tuple(name for name, _ in about),
        )


def _concatenate(parts: list[Examples]) -> Examples:
    return Examples(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in _ARRAYS},
        labels=tuple(label for part in parts for label in part.labels),
        objects=tuple(name for part in parts for name in part.objects),
    )


def _first(examples: Examples, count: int) -> Examples:
    return Examples(
        **{name: getattr(examples, name)[:count] for name in _ARRAYS},
        labels=examples.labels[:count],
        objects=examples.objects[:count],
    )
