"""Clips to time and judge methods on, with how far they moved: simulated, and real windows.

Two frame counts: the four frames of a clip, and its first and last alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.seeding import seed_for
from geotlm_lm.experiments.cases import MOST_TRIES, TASKS, real_cases
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.simulation.series import simulate_series
from geotlm_lm.simulation.simulate import SimulatedClip


@dataclass(frozen=True)
class KnownClip:
    """One clip and what is true of it.

    Args:
        clip: Four frames or two, with a background.
        motion: The truth.
        among: The motions in question.
        source: What the report calls its kind.
        frames: How many frames of their own it has.
        turn_deg: True turn from the first frame to the last, clockwise; None where unknown.
        slide_px: True travel (right, down), px of the clip's frames.
    """

    clip: Clip
    motion: Motion
    among: tuple[Motion, ...]
    source: str
    frames: int
    turn_deg: float | None = None
    slide_px: tuple[float, float] | None = None


def simulated_clips(count: int, seed: int) -> Iterator[KnownClip]:
    """Yield `count` readable clips of each task, of objects kept from training, in both counts."""
    for task in ("rotation", "sliding"):
        for made in _readable(count, seed_for(seed, "runtime", task), EVERYDAY_OBJECTS, task):
            known = _known(made, TASKS[task], f"simulated {task}")
            yield known
            yield replace(known, clip=made.clip.select([0, FRAME_COUNT - 1]), frames=2)


def turning_clips(count: int, seed: int) -> tuple[list[Clip], list[Motion]]:
    """Return simulated turns of training objects, for what is fitted here."""
    made = list(_readable(count, seed_for(seed, "curl"), TRAINING_OBJECTS, "rotation"))
    return [one.clip for one in made], [one.label.motion for one in made]


def real_clips(folder: Path, count: int) -> Iterator[KnownClip]:
    """Yield evenly spaced labelled windows, forwards and backwards, in both frame counts.

    Args:
        folder: As for `evaluate --real`.
        count: Windows per folder of recordings, at most.

    Raises:
        UnreadableClip: If the recordings cannot be read.
    """
    for name, cases in real_cases(folder).items():
        rows = cases.recordings.rows
        few = replace(cases.recordings, rows=rows[:: -(-len(rows) // count)])
        for window in few.windows(frames=("four", "pair"), backwards=True):
            clip = window.clip
            if is_pair := window.frames == "pair":
                clip = clip.select([0, FRAME_COUNT - 1])  # shown as a, a, b, b
            yield KnownClip(
                clip, window.motion, cases.among, f"real {name}", 2 if is_pair else FRAME_COUNT
            )


def _readable(count: int, seed: int, objects: Sequence[str], task: str) -> Iterator[SimulatedClip]:
    given = 0
    for made in simulate_series(seed, MOST_TRIES * count, objects=objects, motions=TASKS[task]):
        if made.label.is_readable:
            given += 1
            yield made
        if given == count:
            return


def _known(made: SimulatedClip, among: tuple[Motion, ...], source: str) -> KnownClip:
    label = made.label
    turns = label.motion in ROTATIONS
    slide = (label.slide_x_mm / made.mm_per_px[0], label.slide_y_mm / made.mm_per_px[1])
    return KnownClip(
        made.clip,
        label.motion,
        among,
        source,
        FRAME_COUNT,
        turn_deg=label.rotation_deg if turns else None,
        slide_px=None if turns else slide,
    )
