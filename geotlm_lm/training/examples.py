"""Simulated clips as training examples: patch inputs beside the simulator's dense truth.

A clip comes in a form that is drawn: a pair or four frames, mirrored, without its idle gel, or
damaged by strong compression, a dim or drifting camera or a faint touch.

Clips are simulated, turned into patch inputs and written in chunks by worker processes; a run that
was killed continues with the first missing chunk. Images are not kept. Each chunk is an array of
records, which is mapped and never read as a whole, beside a file of labels.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM, measure_clip
from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.geometry import FRAME_COUNT, GRID_SIDE, IMAGE_SIDE, TIME_BIN_COUNT
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for, log_uniform
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.recordings.idle import estimate_background
from geotlm_lm.recordings.pixels import drifted, faded, gained, jpeg
from geotlm_lm.runs.run import Workers, do_parts
from geotlm_lm.simulation.gels import HELD_OUT_GELS, TRAINING_GELS
from geotlm_lm.simulation.truth import READABLE_GREY

if TYPE_CHECKING:
    from geotlm_lm.backbone.view import View
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.simulation.simulate import SimulatedClip

CHUNK_CLIPS = 250

PAIR_SHARE = 0.25
"""Share of clips fed as two frames a, a, b, b, the way a frame pair is fed to four frames."""

UNKNOWN_BACKGROUND_SHARE = 0.3
"""Share of clips whose idle gel is estimated from the clip, as for a recording without one."""

UNKNOWN_MARKED_SHARE = 0.4
"""The same of gels that are printed on: what moves leaves its traces in such an estimate."""

MIRRORED_SHARE = 0.15
"""Share of clips flipped left to right, label and all: optics with a mirror in them."""

JPEG_QUALITY = (5.0, 60.0)
"""Below the qualities that the simulator's cameras store; drawn evenly on a log scale."""

DIM_GAIN = (0.15, 0.7)
"""Exposure relative to a well-lit gel, drawn evenly on a log scale; one clip in forty of these is
so dark that a reader would refuse it."""

DRIFT_SHARE = 0.06
DRIFT_GREY = 6.0
"""Most by which the last frame is brighter or darker than the first, about what a camera may drift
before a reader refuses it: one clip in a hundred of these would be."""

KINDS = ("jpeg", "dim", "drift", "faint")
"""Damage, each as likely."""

FAINT_CONTRAST = (0.08, 0.7)
"""Contrast of a touch relative to the simulated one, drawn evenly on a log scale. From 0.04 on, no
more touches of a twentieth of the contrast were told (34 of 60)."""

MOTIONS = (*Motion, *ROTATIONS)
"""What is drawn from: turns twice, so that a clip turns as often as it slides. With two turns among
ten motions a doubtful turn of a round body was taken for a slide (turns right 0.84, slides 0.97 on
577 simulated lids, knobs and the like)."""

VARIED = {"unsteady_share": 0.5, "mixed_share": 0.6, "fast_share": 0.3}
"""What training adds to the plain series beside kinds of gel: unsteady hands, motions that turn,
slide and press at once, and fast cameras, with which the longer of turn and slide goes 0.1 to 1 px
in 21 % of the clips in which it goes farther than that, and 29 % of all turns and slides do,
measured on 400 clips."""

DAMAGED_SHARE = 0.2
"""Share of training's clips damaged by light or storage. Without any, of 60 clips through JPEG of
quality 20 nine were told wrong, of as many that grow 5 % brighter on the way six, and of as many a
fifth as bright five; of undamaged ones none."""

EXAMPLES_VERSION = 10
"""Raised when what is stored of the same clips changes: the stem's inputs, its rigid motions, the
truth or the labels."""

_GRID = (TIME_BIN_COUNT, GRID_SIDE, GRID_SIDE)

EXAMPLE = np.dtype(
    [
        ("inputs", np.float16, (*_GRID, PATCH_INPUT_DIM)),
        ("motions", np.float16, MOTIONS_SHAPE),  # as `Motions.numbers` has them
        ("displacement_px", np.float16, (*_GRID, 2)),  # since the first frame, of the square image
        ("contact", np.float16, _GRID),  # share of each patch
        ("depth_mm", np.float16, _GRID),
    ]
)
"""One example as it is stored: inputs, rigid motions to the last frame, means of each time-bin."""


class StoredRows:
    """The rows of several arrays, one behind the other, read when a slice or row numbers ask."""

    def __init__(self, parts: Sequence[NDArray]) -> None:
        self._parts = tuple(parts)
        self._ends = np.cumsum([len(part) for part in parts])

    def __len__(self) -> int:
        return int(self._ends[-1])

    def __getitem__(self, rows: slice | ArrayLike) -> NDArray:
        wanted = np.arange(len(self))[rows]
        first = self._parts[0]
        values = np.empty((len(wanted), *first.shape[1:]), first.dtype)
        where = np.searchsorted(self._ends, wanted, side="right")
        for index in np.unique(where):
            part, is_here = self._parts[index], where == index
            values[is_here] = part[wanted[is_here] - (self._ends[index] - len(part))]
        return values

    def __array__(self, dtype: DTypeLike = None, copy: bool | None = None) -> NDArray:
        return np.asarray(self[:], dtype)


Rows = NDArray[np.float16] | StoredRows


@dataclass(frozen=True, eq=False)
class Examples:
    """A set of examples: fields of `EXAMPLE`, and of each clip the truth, its object and gel."""

    inputs: Rows
    motions: Rows
    displacement_px: Rows
    contact: Rows
    depth_mm: Rows
    labels: tuple[MotionLabel, ...]
    objects: tuple[str, ...]
    gels: tuple[str, ...]  # kinds of `simulation.gels.GELS`

    def __len__(self) -> int:
        return len(self.labels)


@dataclass(frozen=True)
class ExampleSet:
    """Which examples a set holds."""

    stage: str  # name of the set; with the seed it decides every clip
    count: int
    objects: tuple[str, ...]
    # Whether it is `VARIED` and `DAMAGED_SHARE` of it is damaged, as training is, or the plain
    # series that evaluations use.
    is_varied: bool = True
    is_mixed: bool = False  # whether all of a plain series turns, slides and presses at once
    is_held_out: bool = False  # whether a varied set is on the kinds of gel kept from training

    @property
    def gels(self) -> Mapping[str, float] | None:
        """Shares of kinds of gel; None in the plain series, which is on a GelSight Mini alone."""
        if not self.is_varied:
            return None
        return HELD_OUT_GELS if self.is_held_out else TRAINING_GELS

    def simulated(self, stage_seed: int, first_index: int, count: int) -> Iterator[SimulatedClip]:
        """Yield clips `first_index` .. of the set, each simulated when it is asked for."""
        from geotlm_lm.simulation.simulate import simulate_series

        return simulate_series(
            stage_seed,
            count,
            objects=self.objects,
            first_index=first_index,
            motions=MOTIONS,
            gels=self.gels,
            **(VARIED if self.is_varied else {"mixed_share": float(self.is_mixed)}),
        )

    def recorded(self, simulated: SimulatedClip, rng: np.random.Generator) -> RecordedForm:
        """Return one of the set's clips in a form drawn from `rng`, damaged where training is."""
        return as_recorded(simulated, rng, damaged_share=DAMAGED_SHARE if self.is_varied else 0.0)

    def chunk_paths(self, folder: Path) -> list[Path]:
        """Return the files in `folder` that hold the set."""
        chunk_count = -(-self.count // CHUNK_CLIPS)
        return [folder / f"{self.stage}_{index:04d}.npy" for index in range(chunk_count)]


def simulate_examples(
    folder: Path,
    sets: Sequence[ExampleSet],
    *,
    seed: int,
    workers: int,
    progress: Progress = silent,
) -> None:
    """Simulate the chunks of `sets` that are not yet in `folder`.

    Ctrl-C ends the workers at once; finished chunks are kept. The examples do not depend on the
    number of worker processes.
    """
    jobs = [
        ((wanted, chunk, path), path)
        for wanted in sets
        for chunk, path in enumerate(wanted.chunk_paths(folder))
    ]
    do_parts(
        f"simulate chunks of {CHUNK_CLIPS}",
        partial(_simulate_chunk, seed),
        jobs,
        np.save,
        workers=Workers(workers),
        progress=progress,
    )


def read_examples(folder: Path, *sets: ExampleSet) -> Examples:
    """Read sets that `simulate_examples` wrote, one behind the other.

    Raises:
        UsageError: If the clips touch other objects, or are on other kinds of gel, than wanted, so
            that two sets might share one.
    """
    parts: list[NDArray] = []
    about: list[tuple[str, dict, str]] = []
    for wanted in sets:
        for index, path in enumerate(wanted.chunk_paths(folder)):
            chunk = json.loads(path.with_suffix(".json").read_text())
            allowed = {*wanted.objects, *(wanted.gels or ("mini",))}
            strangers = sorted({name for body, _, gel in chunk for name in (body, gel)} - allowed)
            if strangers:
                raise UsageError(
                    f"{folder}: the {wanted.stage} clips show {', '.join(strangers)}, expected "
                    f"only objects and gels of that set; delete the folder to simulate them again."
                )
            taken = min(len(chunk), wanted.count - index * CHUNK_CLIPS)
            # Mapped: sets are gigabytes, and several processes may train on them.
            parts.append(np.load(path, mmap_mode="r")[:taken])
            about += chunk[:taken]
    rows = {name: StoredRows([part[name] for part in parts]) for name in EXAMPLE.names}
    objects, labels, gels = zip(*about, strict=True)
    return Examples(
        **rows, labels=tuple(map(MotionLabel.from_dict, labels)), objects=objects, gels=gels
    )


def _simulate_chunk(seed: int, chunk: tuple[ExampleSet, int, Path]) -> NDArray:
    """Return the examples of a chunk, once its labels are written beside where it will lie."""
    wanted, number, path = chunk
    first = number * CHUNK_CLIPS
    stage_seed = int(generator_for(seed, "examples", wanted.stage).integers(2**62))
    examples, about = [], []
    clips = wanted.simulated(stage_seed, first, CHUNK_CLIPS)
    for index, simulated in enumerate(clips, start=first):
        recorded = wanted.recorded(simulated, generator_for(stage_seed, "form", index))
        inputs, view, motions = measure_clip(recorded.clip)
        truth = truth_in_view(view, recorded.truth)
        means = (bin_means(values[recorded.order]) for values in truth)
        examples.append((inputs, motions.numbers(), *means))
        about.append([simulated.object_name, recorded.label.to_dict(), simulated.gel_name])
    write_text_atomically(path.with_suffix(".json"), json.dumps(about) + "\n")
    return np.array(examples, EXAMPLE)


@dataclass(frozen=True, eq=False)
class RecordedForm:
    """A simulated clip the way a recording may come."""

    clip: Clip  # its four frames, the background known or estimated
    label: MotionLabel  # what happens until the last of them
    order: list[int]  # which of the simulated frames they are
    truth: SimulatedClip  # what was simulated, in the same image
    is_idle_known: bool  # whether the background is the idle gel itself


def as_recorded(
    simulated: SimulatedClip, rng: np.random.Generator, *, damaged_share: float = 0.0
) -> RecordedForm:
    """Draw a clip's form: all frames or a pair, through a mirror or not, an idle frame or none.

    `damaged_share` is the probability of damage by light or storage.
    """
    order = _frame_order(rng)
    is_mirrored = rng.random() < MIRRORED_SHARE
    label = simulated.label_until(max(order))
    simulated = mirrored(simulated) if is_mirrored else simulated
    is_marked = simulated.scene.optics.markers is not None
    unknown_share = UNKNOWN_MARKED_SHARE if is_marked else UNKNOWN_BACKGROUND_SHARE
    clip, is_idle_known = simulated.clip.select(order), rng.random() >= unknown_share
    # Drawn last: forms of clips without damage stay what they were.
    if damaged_share > 0 and rng.random() < damaged_share:
        clip, label = damage_clip(clip, label, simulated.trace_until(max(order)).change_grey, rng)
    if not is_idle_known:
        clip = replace(clip, background=estimate_background(clip.frames))
    label = MIRRORED.of_label(label) if is_mirrored else label
    return RecordedForm(clip, label, order, simulated, is_idle_known)


def mirrored(simulated: SimulatedClip) -> SimulatedClip:
    """Return what a camera behind a mirror records, and the dense truth in its image.

    The scene and its label stay those of the object; `MotionLabel.mirrored` flips the words.
    """
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


def truth_in_view(view: View, simulated: SimulatedClip) -> tuple[NDArray, NDArray, NDArray]:
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


def damage_clip(
    clip: Clip, label: MotionLabel, change_grey: float, rng: np.random.Generator
) -> tuple[Clip, MotionLabel]:
    """Return a clip with one kind of damage, and what it still tells.

    Only fading is counted against what can be read, not what rounding in a dim picture or
    compression may take of a change that was near the limit before.

    `change_grey` is how much the motion changes the picture, grey levels, as `Trace` has it.
    """
    frames, background = clip.frames, clip.background
    kind = KINDS[rng.integers(len(KINDS))]
    if kind == "jpeg":
        change = partial(jpeg, log_uniform(rng, JPEG_QUALITY))
        frames, background = np.stack([change(frame) for frame in frames]), change(background)
    elif kind == "dim":
        gain = log_uniform(rng, DIM_GAIN)
        frames, background = gained(gain, frames), gained(gain, background)
    elif kind == "drift":
        share, grey = rng.uniform(-1, 1, 2) * (DRIFT_SHARE, DRIFT_GREY)
        frames = drifted(grey, share, frames)
    else:
        contrast = log_uniform(rng, FAINT_CONTRAST)
        frames = faded(contrast, frames, background)
        is_seen = label.motion in (Motion.STILL, Motion.NONE)
        is_seen |= change_grey * contrast >= READABLE_GREY
        visible = tuple(grey * contrast for grey in label.visible_grey)
        is_readable = label.is_readable and bool(is_seen)
        label = replace(label, is_readable=is_readable, visible_grey=visible)
    return replace(clip, frames=frames, background=background), label
