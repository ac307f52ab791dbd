"""Simulated clips as tokens of a released encoder, on disk: made once, read without memory.

Tokens are large (600 kB a clip at 2 x 14 x 14 x 768), so that they lie in files that are mapped; a
run that was killed continues behind the last clip it had finished.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.lib.format import open_memmap
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM, measure_clip
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.atomic import append_text, reserve, write_text_atomically
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import GRID_SIDE, TIME_BIN_COUNT
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.training.examples import ExampleSet
from geotlm_lm.training.recording_forms import RecordedForm

if TYPE_CHECKING:
    from geotlm_lm.backbone.released import ReleasedEncoder

BATCH = 8
"""Clips encoded and written at a time."""


@dataclass(frozen=True, eq=False)
class EncodedClips:
    """Clips as an encoder sees them.

    Args:
        tokens: Global tokens in float32, patch tokens in float16, on disk.
        inputs: What our own stem makes of each clip, float16, on disk, (n, 2, 14, 14, dim): how an
            imprint moved is measured with it, whatever the encoder.
        motions: The rigid motions it finds, likewise, (n, *MOTIONS_SHAPE).
        labels: The truth of each clip.
        objects: Name of the touched object of each clip.
    """

    tokens: Tokens
    inputs: Tensor
    motions: Tensor
    labels: tuple[MotionLabel, ...]
    objects: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.labels)


def encode_examples(
    encoder: ReleasedEncoder,
    folder: Path,
    wanted: ExampleSet,
    *,
    seed: int,
    progress: Progress = silent,
) -> EncodedClips:
    """Return the clips of `wanted`, simulating and encoding those that are not yet in `folder`.

    Args:
        encoder: The encoder.
        folder: Where the tokens of this encoder, and of no other, lie.
        wanted: Name, number and objects of the clips.
        seed: Root seed; with the name it decides every clip.
        progress: Told how far it is.

    Raises:
        UsageError: If tokens are too large for half precision.
    """
    folder.mkdir(parents=True, exist_ok=True)
    about = folder / f"{wanted.stage}.jsonl"
    lines = _finished(about)
    arrays = _arrays(encoder, folder, wanted, is_new=not lines)
    for batch in _batches(wanted, seed, len(lines)):
        rows = slice(len(lines), len(lines) + len(batch))
        _write(encoder, batch, arrays, rows)
        # The label comes last: a clip is finished once it is there.
        new = [json.dumps([name, one.label.to_dict()]) for name, one in batch]
        append_text(about, "".join(f"{line}\n" for line in new))
        lines += new
        progress(f"encode {wanted.stage}", len(lines), wanted.count)
    return _read(folder, wanted, [json.loads(line) for line in lines[: wanted.count]])


def _finished(about: Path) -> list[str]:
    """Return the lines of finished clips; half a line that a kill left behind is cut off."""
    text = about.read_text() if about.exists() else ""
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        write_text_atomically(about, whole)
    return whole.splitlines()


def _batches(wanted: ExampleSet, seed: int, first: int) -> Iterator[list[tuple[str, RecordedForm]]]:
    stage_seed = int(generator_for(seed, "encoded", wanted.stage).integers(2**62))
    clips = wanted.simulated(stage_seed, first, max(wanted.count - first, 0))
    batch = []
    for index, simulated in enumerate(clips, start=first):
        rng = generator_for(stage_seed, "form", index)
        batch.append((simulated.object_name, wanted.recorded(simulated, rng)))
        if len(batch) == BATCH or index == wanted.count - 1:
            yield batch
            batch = []


def _write(
    encoder: ReleasedEncoder,
    batch: list[tuple[str, RecordedForm]],
    arrays: tuple[NDArray, ...],
    rows: slice,
) -> None:
    tokens = encoder.encode([one.clip for _, one in batch])
    patches = tokens.patches.half()
    if not bool(torch.isfinite(patches).all() and torch.isfinite(tokens.global_token).all()):
        raise UsageError(
            f"{encoder.row.title}: tokens up to {float(tokens.patches.abs().max()):.3g} were "
            f"found, expected below 65504; the file's weights are not those of a trained encoder."
        )
    looks = [measure_clip(one.clip) for _, one in batch]
    inputs = np.stack([one.inputs for one in looks])
    motions = np.stack([one.motions.numbers() for one in looks])
    made = tokens.global_token.numpy(), patches.numpy(), inputs, motions
    for array, values in zip(arrays, made, strict=True):
        array[rows] = values
    for array in arrays:
        array.flush()


def _paths(folder: Path, wanted: ExampleSet) -> list[Path]:
    names = ("global", "patches", "inputs", "motions")
    return [folder / f"{wanted.stage}_{name}.npy" for name in names]


def _arrays(
    encoder: ReleasedEncoder, folder: Path, wanted: ExampleSet, *, is_new: bool
) -> tuple[NDArray, ...]:
    inputs = (TIME_BIN_COUNT, GRID_SIDE, GRID_SIDE, PATCH_INPUT_DIM)
    each = ((encoder.width,), encoder.patch_shape, inputs, MOTIONS_SHAPE)
    shapes = [(wanted.count, *one) for one in each]
    kinds = (np.float32, *[np.float16] * 3)
    return tuple(
        _array(path, kind, shape, is_new=is_new)
        for path, kind, shape in zip(_paths(folder, wanted), kinds, shapes, strict=True)
    )


def _array(path: Path, kind: type, shape: tuple[int, ...], *, is_new: bool) -> NDArray:
    if not is_new:
        return open_memmap(path, "r+")
    array = open_memmap(path, "w+", kind, shape)
    reserve(path)  # a mapped part for which there is no room ends the process
    return array


def _read(folder: Path, wanted: ExampleSet, about: list) -> EncodedClips:
    # Copy-on-write, so that torch need not warn of memory it may not write.
    plain, patches, inputs, motions = (
        torch.from_numpy(np.load(path, mmap_mode="c")) for path in _paths(folder, wanted)
    )
    return EncodedClips(
        tokens=Tokens(plain, patches),
        inputs=inputs,
        motions=motions,
        labels=tuple(MotionLabel.from_dict(label) for _, label in about),
        objects=tuple(name for name, _ in about),
    )
