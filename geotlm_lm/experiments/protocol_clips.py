"""The clips of the paper's protocols, seen once by a frozen backbone and kept on disk as tokens.

One file per task and object. The folder's name follows from the backbone, from what was asked for
and from the code that makes clips and tokens, so that no file outlives what it was made by.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

import geotlm_lm
from geotlm_lm.backbone.released import ReleasedEncoder
from geotlm_lm.backbone.tokens import Backbone, Tokens
from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, GRID_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.seeding import seed_for
from geotlm_lm.experiments.cases import MOST_TRIES, TASKS
from geotlm_lm.probe.curl import curl_features
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.simulation.series import SERIES_VERSION, simulate_series
from geotlm_lm.simulation.simulate import SimulatedClip
from geotlm_lm.training.forms import bin_means, truth_in
from geotlm_lm.training.geometry import ALL_MOTIONS, TokenSet
from geotlm_lm.training.motion_loss import counts_motion

FRAME_COUNTS = (FRAME_COUNT, 2)
"""Frames the backbone is given: all of them, or the first and the last, fed as a, a, b, b."""

_ORDERS = {FRAME_COUNT: (0, 1, 2, 3), 2: (0, 0, 3, 3)}

ENCODE_BATCH = 8
"""Clips held in memory as pictures."""

SOURCES = (
    "core",
    "simulation",
    "backbone",
    "probe",
    "training/forms.py",
    "training/motion_loss.py",
    "experiments/cases.py",
    "experiments/protocol_clips.py",
)
"""Rooms and files whose code decides what is kept."""

_TOKENS = ("global", "patches")


@dataclass(frozen=True)
class ProtocolClips:
    """Which clips there are.

    Args:
        objects: What is touched.
        clips: Readable clips of each object in each task.
        seed: Root of the scenes.
    """

    objects: tuple[str, ...]
    clips: int
    seed: int


@dataclass(frozen=True, eq=False)
class TaskClips:
    """One task's clips as tokens, and what the classical references made of them.

    Args:
        data: Tokens and truth, by the number of frames the backbone was given.
        objects: What is touched in each clip.
        flow: The motion that optical flow and a rigid fit name, clip by clip.
        curl: Features of the curl, (n, 5).
        unreadable: How many clips were left out because their images do not show the motion.
        seconds: What simulating and encoding them took, in whichever run did it.
    """

    data: dict[int, TokenSet]
    objects: tuple[str, ...]
    flow: tuple[Motion, ...]
    curl: NDArray[np.float32]
    unreadable: int
    seconds: float

    @cached_property
    def truths(self) -> tuple[Motion, ...]:
        """The motion of each clip."""
        return tuple(ALL_MOTIONS[index] for index in self.data[FRAME_COUNT].motions.tolist())

    @property
    def has_truth(self) -> bool:
        """Whether the true displacement is known on the grid of the patch tokens."""
        return self.data[FRAME_COUNT].contact is not None


def cache_folder(root: Path, backbone: Backbone, wanted: ProtocolClips) -> Path:
    """Return the folder in which the tokens of `wanted`, as `backbone` sees them, belong."""
    about = asdict(wanted) | {"series": SERIES_VERSION, "orders": _ORDERS}
    made = hashlib.sha256(json.dumps(about, sort_keys=True).encode())
    made.update(source_digest(*SOURCES).encode())
    return root / f"tokens-{backbone_digest(backbone)}-{made.hexdigest()[:12]}"


def backbone_digest(backbone: Backbone) -> str:
    """Return twelve hex digits of a backbone's kind, sizes and weights."""
    if isinstance(backbone, ReleasedEncoder):
        about = json.dumps(backbone.describe(), sort_keys=True)
        return hashlib.sha256(about.encode()).hexdigest()[:12]
    found = hashlib.sha256(type(backbone).__name__.encode())
    for name, value in backbone.state_dict().items():
        found.update(name.encode())
        found.update(value.detach().cpu().contiguous().numpy().tobytes())
    return found.hexdigest()[:12]


def source_digest(*parts: str) -> str:
    """Return twelve hex digits of the package's code in some rooms or files."""
    package = Path(geotlm_lm.__file__).parent
    found = hashlib.sha256()
    for part in parts:
        path = package / part
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            found.update(file.relative_to(package).as_posix().encode())
            found.update(file.read_bytes())
    return found.hexdigest()[:12]


def read_or_encode(
    folder: Path,
    backbone: Backbone,
    wanted: ProtocolClips,
    task: str,
    progress: Callable[[str, int, int], None] = lambda what, done, total: None,
) -> TaskClips:
    """Return a task's clips, simulating and encoding only the objects that are not in `folder`.

    Args:
        folder: From `cache_folder`.
        backbone: The frozen backbone.
        wanted: Which clips.
        task: "rotation" or "sliding".
        progress: Told of every object that is done.

    Raises:
        UsageError: If the simulator finds too few readable clips, or tokens are too large for half
            precision.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = []
    for done, name in enumerate(wanted.objects):
        path = folder / f"{task}-{name}.npz"
        if not path.exists():
            progress(
                f"{task}, clips encoded", done * wanted.clips, len(wanted.objects) * wanted.clips
            )
            arrays = _encoded(backbone, wanted, task, name)
            with replacing(path) as stream:
                np.savez(stream, **arrays)
        with np.load(path, allow_pickle=False) as stored:
            parts.append({key: stored[key] for key in stored.files})
    total = len(wanted.objects) * wanted.clips
    progress(f"{task}, clips encoded", total, total)
    return _joined(parts, wanted)


def _encoded(backbone: Backbone, wanted: ProtocolClips, task: str, name: str) -> dict[str, NDArray]:
    """Simulate and encode the clips of one object; return what its file holds."""
    started = time.perf_counter()
    columns: dict[str, list] = {}
    batch: list[SimulatedClip] = []
    unreadable = given = 0
    for made in _series(wanted, task, name):
        unreadable += not made.label.is_readable
        if made.label.is_readable:
            batch.append(made)
            given += 1
        if len(batch) == ENCODE_BATCH or (batch and given == wanted.clips):
            for key, values in _arrays(backbone, batch, task).items():
                columns.setdefault(key, []).append(values)
            batch = []
        if given == wanted.clips:
            joined = {key: np.concatenate(values) for key, values in columns.items()}
            seconds = time.perf_counter() - started
            return joined | {"unreadable": np.array(unreadable), "seconds": np.array(seconds)}
    raise UsageError(
        f"{name}: {given} readable clips of {task} among {MOST_TRIES * wanted.clips} simulated "
        f"ones, expected {wanted.clips}; ask for more clips, or leave the object out."
    )


def _series(wanted: ProtocolClips, task: str, name: str) -> Iterator[SimulatedClip]:
    return simulate_series(
        seed_for(wanted.seed, "protocols", task, name),
        MOST_TRIES * wanted.clips,
        objects=(name,),
        motions=TASKS[task],
    )


def _arrays(backbone: Backbone, batch: Sequence[SimulatedClip], task: str) -> dict[str, NDArray]:
    clips = [made.clip for made in batch]
    flow = RigidFlow()
    arrays = {
        "motion": np.array([ALL_MOTIONS.index(made.label.motion) for made in batch]),
        "counts_motion": np.array([counts_motion(made.label) for made in batch]),
        "flow": np.array([ALL_MOTIONS.index(flow.predict(clip, TASKS[task])) for clip in clips]),
        "curl": np.stack([curl_features(clip) for clip in clips]),
    }
    for frames in FRAME_COUNTS:
        order = _ORDERS[frames]
        tokens = backbone.encode([clip.select(order) for clip in clips])
        patches = tokens.patches.half()
        if not bool(torch.isfinite(patches).all() and torch.isfinite(tokens.global_token).all()):
            raise UsageError(
                f"tokens up to {float(tokens.patches.abs().max()):.3g} were found, expected below "
                f"65504; the weights are not those of a trained encoder."
            )
        arrays |= {f"global_{frames}": tokens.global_token.numpy()}
        arrays |= {f"patches_{frames}": patches.numpy()}
        arrays |= _truth(tokens, batch, order, frames)
    return arrays


def _truth(
    tokens: Tokens, batch: Sequence[SimulatedClip], order: Sequence[int], frames: int
) -> dict[str, NDArray]:
    """Return true shear change and contact on the tokens' grid; nothing where it is another one."""
    if tokens.patches.shape[2:4] != (GRID_SIDE, GRID_SIDE) or None in tokens.views:
        return {}
    changes, contacts = [], []
    for view, made in zip(tokens.views, batch, strict=True):
        moved, contact, _ = (bin_means(values[list(order)]) for values in truth_in(view, made))
        changes.append(moved[1] - moved[0])
        contacts.append(contact.mean(axis=0))
    return {
        f"shear_change_{frames}": np.stack(changes).astype(np.float32),
        f"contact_{frames}": np.stack(contacts).astype(np.float32),
    }


def _joined(parts: Sequence[dict[str, Any]], wanted: ProtocolClips) -> TaskClips:
    def column(key: str) -> torch.Tensor | None:
        if key not in parts[0]:
            return None
        return torch.from_numpy(np.concatenate([part[key] for part in parts]))

    motions = column("motion")
    data = {
        frames: TokenSet(
            tokens=Tokens(*(column(f"{part}_{frames}") for part in _TOKENS)),
            shear_change=column(f"shear_change_{frames}"),
            contact=column(f"contact_{frames}"),
            motions=motions,
            is_readable=torch.ones(len(motions), dtype=torch.bool),
            counts_motion=column("counts_motion"),
        )
        for frames in FRAME_COUNTS
    }
    return TaskClips(
        data=data,
        objects=tuple(name for name in wanted.objects for _ in range(wanted.clips)),
        flow=tuple(ALL_MOTIONS[index] for index in column("flow").tolist()),
        curl=column("curl").numpy(),
        unreadable=sum(int(part["unreadable"]) for part in parts),
        seconds=sum(float(part["seconds"]) for part in parts),
    )
