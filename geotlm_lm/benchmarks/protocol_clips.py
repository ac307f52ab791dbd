"""The clips of the paper's protocols as a frozen backbone and the classical references see them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.backbone.tokens import Backbone, Tokens
from geotlm_lm.benchmarks.cases.simulated import MOST_TRIES, TASKS
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import FRAME_COUNT, GRID_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.core.process import Progress
from geotlm_lm.probe.curl import curl_features
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.simulation.simulate import SimulatedClip, simulate_series
from geotlm_lm.training.geometry import ALL_MOTIONS, TokenSet
from geotlm_lm.training.recording_forms import bin_means, truth_in_view
from geotlm_lm.training.truth import counts_motion

ORDERS = {FRAME_COUNT: (0, 1, 2, 3), 2: (0, 0, 3, 3)}
"""Frames the backbone is given: all of them, or the first and the last, fed as a, a, b, b."""

ENCODE_BATCH = 8
"""Clips held in memory as pictures."""


@dataclass(frozen=True, eq=False)
class TaskClips:
    """One task's clips as tokens, and what the classical references made of them.

    Args:
        data: Tokens and truth, by the number of frames the backbone was given.
        objects: What is touched in each clip.
        truths: The motion of each clip.
        flow: The motion that optical flow and a rigid fit name, clip by clip.
        curl: Features of the curl, (n, 5).
    """

    data: dict[int, TokenSet]
    objects: tuple[str, ...]
    truths: Sequence[Motion]
    flow: Sequence[Motion]
    curl: NDArray[np.float32]

    @property
    def has_truth(self) -> bool:
        """Whether the true displacement is known on the grid of the patch tokens."""
        return self.data[FRAME_COUNT].contact is not None


def task_clips(
    backbone: Backbone, task: str, objects: Sequence[str], count: int, seed: int, progress: Progress
) -> TaskClips:
    """Simulate and encode `count` readable clips of each object in a task, batch by batch.

    Raises:
        UsageError: If the simulator finds too few readable clips, or tokens are too large for half
            precision.
    """
    columns: dict[str, list[NDArray]] = {}
    for done, name in enumerate(objects):
        progress(f"paper's protocols, {task}: objects encoded", done, len(objects))
        for batch in _batches(task, name, count, seed):
            for key, values in _arrays(backbone, batch, task).items():
                columns.setdefault(key, []).append(values)
    arrays = {key: np.concatenate(values) for key, values in columns.items()}
    data = {frames: _token_set(arrays, frames) for frames in ORDERS}
    names = tuple(name for name in objects for _ in range(count))
    truths, flow = ([ALL_MOTIONS[index] for index in arrays[key]] for key in ("motion", "flow"))
    return TaskClips(data, names, truths, flow, arrays["curl"])


def _batches(task: str, name: str, count: int, seed: int) -> Iterator[list[SimulatedClip]]:
    """Yield an object's readable clips, so many at a time as are held in memory."""
    most, motions = MOST_TRIES * count, TASKS[task]
    seed = seed_for(seed, "protocols", task, name)
    series = simulate_series(seed, most, objects=(name,), motions=motions)
    readable = islice((made for made in series if made.label.is_readable), count)
    given = 0
    while batch := list(islice(readable, ENCODE_BATCH)):
        given += len(batch)
        yield batch
    if given < count:
        raise UsageError(
            f"{name}: {given} readable clips of {task} among {most} simulated ones, expected "
            f"{count}; ask for more clips, or leave the object out."
        )


def _arrays(backbone: Backbone, batch: Sequence[SimulatedClip], task: str) -> dict[str, NDArray]:
    clips, flow = [made.clip for made in batch], RigidFlow()
    arrays = {
        "motion": np.array([ALL_MOTIONS.index(made.label.motion) for made in batch]),
        "counts_motion": np.array([counts_motion(made.label) for made in batch]),
        "flow": np.array([ALL_MOTIONS.index(flow.predict(clip, TASKS[task])) for clip in clips]),
        "curl": np.stack([curl_features(clip) for clip in clips]),
    }
    for frames, order in ORDERS.items():
        tokens = backbone.encode([clip.select(order) for clip in clips])
        patches = tokens.patches.half()
        if not bool(torch.isfinite(patches).all() and torch.isfinite(tokens.global_token).all()):
            raise UsageError(
                f"tokens up to {float(tokens.patches.abs().max()):.3g} were found, expected below "
                f"65504; the weights are not those of a trained encoder."
            )
        found = {"global": tokens.global_token.numpy(), "patches": patches.numpy()}
        found |= _truth(tokens, batch, order)
        arrays |= {f"{key}_{frames}": values for key, values in found.items()}
    return arrays


def _truth(
    tokens: Tokens, batch: Sequence[SimulatedClip], order: Sequence[int]
) -> dict[str, NDArray]:
    """Return true shear change and contact on the tokens' grid; nothing where it is another one."""
    if tokens.patches.shape[2:4] != (GRID_SIDE, GRID_SIDE) or None in tokens.views:
        return {}
    changes, contacts = [], []
    for view, made in zip(tokens.views, batch, strict=True):
        moved, contact, _ = (bin_means(values[list(order)]) for values in truth_in_view(view, made))
        changes.append(moved[1] - moved[0])
        contacts.append(contact.mean(axis=0))
    found = {"shear_change": np.stack(changes), "contact": np.stack(contacts)}
    return {key: values.astype(np.float32) for key, values in found.items()}


def _token_set(arrays: dict[str, NDArray], frames: int) -> TokenSet:
    found = {key: torch.from_numpy(values) for key, values in arrays.items()}
    return TokenSet(
        tokens=Tokens(found[f"global_{frames}"], found[f"patches_{frames}"]),
        shear_change=found.get(f"shear_change_{frames}"),
        contact=found.get(f"contact_{frames}"),
        motions=found["motion"],
        is_readable=torch.ones(len(found["motion"]), dtype=torch.bool),
        counts_motion=found["counts_motion"],
    )
