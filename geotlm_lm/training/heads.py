"""Train DGR, probe and language model on a released encoder; its own weights stay as they are.

The heads learn from simulated clips alone. DGR is trained the paper's way: no released encoder was
pretrained towards a displacement that its shear could start from. Tokens are large (600 kB a clip
at 2 x 14 x 14 x 768), so that they lie in a file that is mapped; a run that was killed continues
behind the last clip it had finished.
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

from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.checkpoint import Bundle, embedded_bundle_dir, embedded_reader
from geotlm_lm.core.files import append_text, reserve, write_text_atomically
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.query.reader import Reader
from geotlm_lm.training.config import (
    HEADS_PRESETS,
    about_examples,
    claim_folder,
    example_sets,
    preset_named,
)
from geotlm_lm.training.examples import EXAMPLE, ExampleSet, RecordedForm
from geotlm_lm.training.geometry import TokenSet, halved
from geotlm_lm.training.train import learn_language, learn_perception

if TYPE_CHECKING:
    from geotlm_lm.backbone.released import ReleasedEncoder

BATCH = 8
"""Clips encoded and written at a time."""


def train_heads(
    encoder: ReleasedEncoder, preset: str, out: Path, seed: int, progress: Progress = silent
) -> Bundle:
    """Return a model that sees through `encoder`; the heads' checkpoints are kept in `out`.

    A run of the same encoder, preset and seed in it is continued.

    Raises:
        UsageError: If the preset is unknown or the folder holds another run.
    """
    settings = preset_named(preset, HEADS_PRESETS)
    about = encoder.describe() | about_examples(settings, seed)
    claim_folder(
        out,
        about,
        run="another encoder, preset, seed or version of this program",
        advice="give an empty folder by --run-folder",
    )
    sets = example_sets(settings)
    learned, validation = (
        encode_examples(encoder, out / "tokens", sets[name], seed=seed, progress=progress)
        for name in ("heads", "validation")
    )
    token_sets = (TokenSet.of(clips.tokens, clips.labels) for clips in (learned, validation))
    epochs = settings.geometry_epochs
    shared = {"seed": seed, "out": out, "progress": progress}
    seen = learn_perception(encoder, learned, validation, *token_sets, epochs, **shared)
    start = embedded_bundle_dir()
    folder = learn_language(seen, settings, seed, out, start, "slots", progress=progress)
    own = Reader.load(folder)
    calibration = embedded_reader().calibration
    return seen.bundle(Reader(own.decoder, own.spelling, calibration), about)


@dataclass(frozen=True, eq=False)
class EncodedClips:
    """Clips as an encoder sees them."""

    tokens: Tokens  # global tokens in float32, patch tokens in float16, on disk
    # What our own stem measures in each clip, float16, on disk, (n, 2, 14, 14, dim): how an
    # imprint moved is measured with it, whatever the encoder.
    inputs: NDArray[np.float16]
    motions: NDArray[np.float16]  # the rigid motions it measures, likewise, (n, *MOTIONS_SHAPE)
    labels: tuple[MotionLabel, ...]
    objects: tuple[str, ...]  # name of the touched object of each clip

    def __len__(self) -> int:
        return len(self.labels)

    def tokens_of(self, rows: slice) -> Tokens:
        """Return the tokens of some clips in float32."""
        return Tokens(self.tokens.global_token[rows], self.tokens.patches[rows].float())


def encode_examples(
    encoder: ReleasedEncoder,
    folder: Path,
    wanted: ExampleSet,
    *,
    seed: int,
    progress: Progress = silent,
) -> EncodedClips:
    """Return the clips of `wanted`, simulating and encoding those that are not yet in `folder`.

    The folder holds tokens of this encoder alone; seed and name decide every clip.
    """
    folder.mkdir(parents=True, exist_ok=True)
    about, path = folder / f"{wanted.stage}.jsonl", folder / f"{wanted.stage}.npy"
    lines = _finished(about)
    stored = _stored(path, encoder, wanted.count, is_new=not lines)
    for batch in _batches(wanted, seed, len(lines)):
        rows = slice(len(lines), len(lines) + len(batch))
        tokens = halved(encoder.encode([recorded.clip for _, recorded in batch]))
        looks = [measure_clip(recorded.clip) for _, recorded in batch]
        stored["global"][rows] = tokens.global_token.numpy()
        stored["patches"][rows] = tokens.patches.numpy()
        stored["inputs"][rows] = np.stack([look.inputs for look in looks])
        stored["motions"][rows] = np.stack([look.motions.numbers() for look in looks])
        stored.flush()
        # The label comes last: a clip is finished once it is there.
        new = [json.dumps([name, recorded.label.to_dict()]) for name, recorded in batch]
        append_text(about, "".join(f"{line}\n" for line in new))
        lines += new
        progress(f"encode {wanted.stage}", len(lines), wanted.count)
    # Copy-on-write, so that torch need not warn of memory it may not write.
    stored = np.load(path, mmap_mode="c")
    pairs = [json.loads(line) for line in lines[: wanted.count]]
    return EncodedClips(
        tokens=Tokens(torch.from_numpy(stored["global"]), torch.from_numpy(stored["patches"])),
        inputs=stored["inputs"],
        motions=stored["motions"],
        labels=tuple(MotionLabel.from_dict(label) for _, label in pairs),
        objects=tuple(name for name, _ in pairs),
    )


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


def _stored(path: Path, encoder: ReleasedEncoder, count: int, *, is_new: bool) -> np.memmap:
    """Return the mapped records of clips; a mapped part without room would end the process."""
    if not is_new:
        return open_memmap(path, "r+")
    fields = [
        ("global", np.float32, (encoder.width,)),
        ("patches", np.float16, encoder.patch_shape),
        *((name, EXAMPLE[name].base, EXAMPLE[name].shape) for name in ("inputs", "motions")),
    ]
    stored = open_memmap(path, "w+", np.dtype(fields, align=True), (count,))
    reserve(path)
    return stored
