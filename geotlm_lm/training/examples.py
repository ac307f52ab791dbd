"""Simulated clips as training examples: patch inputs beside the simulator's dense truth.

Clips are simulated, turned into patch inputs and written in chunks by worker processes; a run that
was killed continues with the first missing chunk. Images are not kept.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.interrupts import uninterrupted_step
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.local_pool import each_done
from geotlm_lm.training.recording_forms import RecordedForm, as_recorded, bin_means, truth_in_view
from geotlm_lm.training.stored_rows import StoredPart, StoredRows

if TYPE_CHECKING:
    from geotlm_lm.simulation.simulate import SimulatedClip

CHUNK_CLIPS = 250

MOTIONS = (*Motion, *ROTATIONS)
"""What is drawn from: turns twice, so that a clip turns as often as it slides. With two turns among
ten motions a doubtful turn of a round body was taken for a slide (turns right 0.84, slides 0.97 on
577 simulated lids, knobs and the like)."""

VARIED = {"marker_share": 0.2, "unsteady_share": 0.5, "mixed_share": 0.6}
"""What training adds to the plain series: gels with markers, unsteady hands, and motions that turn,
slide and press at once."""

DAMAGED_SHARE = 0.2
"""Share of training's clips damaged by light or storage. Without any, of 60 clips through JPEG of
quality 20 nine were told wrong, of as many that grow 5 % brighter on the way six, and of as many a
fifth as bright five; of undamaged ones none."""

EXAMPLES_VERSION = 8
"""Raised when what is stored of the same clips changes: the stem's inputs, its rigid motions, the
truth or the labels."""

_ARRAYS = ("inputs", "motions", "displacement_px", "contact", "depth_mm")


Rows = NDArray[np.float16] | StoredRows


@dataclass(frozen=True, eq=False)
class Examples:
    """A set of examples; arrays, or rows that are read when they are asked for, side by side.

    Args:
        inputs: Patch inputs, float16, shape (n, 2, 14, 14, dim).
        motions: The rigid motions to the last frame, as `Motions.numbers` has them, float16,
            shape (n, 4, 7).
        displacement_px: True displacement since the first frame, mean per time-bin, float16,
            shape (n, 2, 14, 14, 2), pixels of the square image.
        contact: Share of each patch in contact per time-bin, float16, shape (n, 2, 14, 14).
        depth_mm: Mean indentation per time-bin, float16, shape (n, 2, 14, 14).
        labels: The truth of each clip.
        objects: Name of the touched object of each clip.
    """

    inputs: Rows
    motions: Rows
    displacement_px: Rows
    contact: Rows
    depth_mm: Rows
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
        is_varied: Whether it is `VARIED` and `DAMAGED_SHARE` of it is damaged, as training is, or
            the plain series that evaluations use.
        is_mixed: Whether all of a plain series turns, slides and presses at once.
    """

    stage: str
    count: int
    objects: tuple[str, ...]
    is_varied: bool = True
    is_mixed: bool = False

    def simulated(self, stage_seed: int, first_index: int, count: int) -> Iterator[SimulatedClip]:
        """Yield clips `first_index` .. of the set, each made when it is asked for."""
        from geotlm_lm.simulation.simulate import simulate_series

        return simulate_series(
            stage_seed,
            count,
            objects=self.objects,
            first_index=first_index,
            motions=MOTIONS,
            **(VARIED if self.is_varied else {"mixed_share": float(self.is_mixed)}),
        )

    def recorded(self, simulated: SimulatedClip, rng: np.random.Generator) -> RecordedForm:
        """Return one of the set's clips in a form drawn from `rng`, damaged where training is."""
        return as_recorded(simulated, rng, damaged_share=DAMAGED_SHARE if self.is_varied else 0.0)

    def chunk_paths(self, folder: Path) -> list[Path]:
        """Return the files in `folder` that hold the set."""
        chunk_count = -(-self.count // CHUNK_CLIPS)
        return [folder / f"{self.stage}_{index:04d}.npz" for index in range(chunk_count)]


def simulate_examples(
    folder: Path,
    sets: Sequence[ExampleSet],
    *,
    seed: int,
    workers: int,
    progress: Progress = silent,
) -> None:
    """Simulate the chunks of `sets` that are not yet in `folder`.

    Ctrl-C ends the workers at once; finished chunks are kept.

    Args:
        folder: Where the chunks lie.
        sets: What to simulate.
        seed: Root seed.
        workers: Processes; the examples do not depend on it.
        progress: Told how far it is.
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
    for _ in each_done(_write_chunk, jobs, workers):
        done += 1
        progress(f"simulate chunks of {CHUNK_CLIPS}", done, chunk_count)


def read_examples(folder: Path, *wanted: ExampleSet) -> Examples:
    """Read sets that `simulate_examples` wrote, one behind the other.

    Raises:
        UsageError: If the clips touch other objects than wanted, so that two sets might share one.
    """
    # Only labels are read now: sets are gigabytes, and several processes may train on them.
    parts: dict[str, list[StoredPart]] = {name: [] for name in _ARRAYS}
    labels: list[MotionLabel] = []
    objects: list[str] = []
    for one in wanted:
        for index, path in enumerate(one.chunk_paths(folder)):
            about = _about(path)
            taken = min(len(about), one.count - index * CHUNK_CLIPS)
            for name in _ARRAYS:
                parts[name].append(StoredPart.of(path, name, taken))
            labels += [MotionLabel.from_dict(label) for _, label in about[:taken]]
            objects += [name for name, _ in about[:taken]]
            _refuse_strangers(folder, one, [name for name, _ in about])
    arrays = {name: StoredRows(found) for name, found in parts.items()}
    return Examples(**arrays, labels=tuple(labels), objects=tuple(objects))


def _refuse_strangers(folder: Path, wanted: ExampleSet, objects: Sequence[str]) -> None:
    strangers = sorted(set(objects) - set(wanted.objects))
    if strangers:
        raise UsageError(
            f"{folder}: the {wanted.stage} clips touch {', '.join(strangers)}, expected only "
            f"objects of that set; delete the folder to simulate them again."
        )


def _write_chunk(job: tuple[Path, ExampleSet, int, int]) -> None:
    path, wanted, chunk, seed = job
    first = chunk * CHUNK_CLIPS
    stage_seed = int(generator_for(seed, "examples", wanted.stage).integers(2**62))
    arrays: dict[str, list] = {name: [] for name in _ARRAYS}
    about = []
    clips = wanted.simulated(stage_seed, first, CHUNK_CLIPS)
    for index, simulated in enumerate(clips, start=first):
        rng = generator_for(stage_seed, "form", index)
        recorded = wanted.recorded(simulated, rng)
        for name, values in zip(_ARRAYS, _example(recorded), strict=True):
            arrays[name].append(values)
        about.append([simulated.object_name, recorded.label.to_dict()])
    stacked = {name: np.stack(values).astype(np.float16) for name, values in arrays.items()}
    with (
        uninterrupted_step(),
        replacing(path) as stream,
    ):  # a worker ended here leaves no part of a file
        np.savez(stream, about=np.array(json.dumps(about)), **stacked)


def _example(recorded: RecordedForm) -> tuple[NDArray, ...]:
    """Return the arrays of one example, in the order of `_ARRAYS`."""
    from geotlm_lm.backbone.stem import measure_clip

    inputs, view, motions = measure_clip(recorded.clip)
    truth = truth_in_view(view, recorded.truth)
    return inputs, motions.numbers(), *(bin_means(values[recorded.order]) for values in truth)


def _about(path: Path) -> list:
    """Return the object and the label of each clip of a chunk."""
    with np.load(path, allow_pickle=False) as stored:
        return json.loads(str(stored["about"]))
