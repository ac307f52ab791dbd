"""Windows of labelled real recordings: four frames and pairs, and as other sensors show them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, turn_by_quarter
from geotlm_lm.data.labelled_recordings import (
    LabelledRecordings,
    find_labelled_recordings,
)

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip


@dataclass(frozen=True)
class RealCases:
    """The windows of labelled recordings: four frames and pairs, forwards and backwards.

    Args:
        recordings: One folder of labelled recordings.
    """

    recordings: LabelledRecordings

    @property
    def among(self) -> tuple[Motion, ...]:
        """The smallest task that holds every label of the recordings."""
        return smallest_task(row.motion for row in self.recordings.rows)

    def __len__(self) -> int:
        return 4 * len(self.recordings.rows)

    def __iter__(self) -> Iterator[Case]:
        for window in self.recordings.windows(frames=("four", "pair"), backwards=True):
            tags = {
                "frames": window.frames,
                "played": "backwards" if window.is_backwards else "forwards",
                "fps": "unknown" if window.clip.fps is None else f"{window.clip.fps:g}",
            }
            row = window.row
            yield Case(window.clip, window.motion, row.object_id, row.object_family, tags)


@dataclass(frozen=True)
class FourFrames:
    """The four-frame windows of labelled recordings, both ways, as something else shows them.

    Args:
        recordings: One folder of labelled recordings.
        shown: Takes a clip and its motion, returns how it is shown and its motion there.
    """

    recordings: LabelledRecordings
    shown: Callable[[Clip, Motion], tuple[Clip, Motion]]

    def __len__(self) -> int:
        return 2 * len(self.recordings.rows)

    def __iter__(self) -> Iterator[Case]:
        for window in self.recordings.windows(frames=("four",), backwards=True):
            (clip, motion), row = self.shown(window.clip, window.motion), window.row
            yield Case(clip, motion, row.object_id, row.object_family, {})


def smallest_task(motions: Iterable[Motion]) -> tuple[Motion, ...]:
    """Return the turns, the slides, both or all ten: the first that holds every motion."""
    held = set(motions)
    return next(x for x in (ROTATIONS, SLIDES, DIRECTED, tuple(Motion)) if held <= set(x))


def without_idle_frame(clip: Clip, motion: Motion) -> tuple[Clip, Motion]:
    """Show a clip as one that starts in contact: each method has to guess the idle gel."""
    return replace(clip, background=None), motion


def held_across(clip: Clip, motion: Motion) -> tuple[Clip, Motion]:
    """Show a clip as a sensor held across records it, turned by 90 degrees counterclockwise."""
    return turned_by_quarter(clip), turn_by_quarter(motion)


def turned_by_quarter(clip: Clip) -> Clip:
    """Return a clip turned by 90 degrees counterclockwise."""
    frames = np.rot90(clip.frames, axes=(1, 2))
    idle = None if clip.background is None else np.rot90(clip.background)
    return replace(
        clip,
        frames=np.ascontiguousarray(frames),
        background=None if idle is None else np.ascontiguousarray(idle),
    )


def by_task(cases: RealCases) -> dict[str, RealCases]:
    """Split recordings whose labels are of more than one task, so that each is asked as a task.

    Returns:
        What to add to the name -> the recordings of that part; nothing is added where all labels
        are of one task.
    """
    recordings = cases.recordings
    tasks = {" rotation": ROTATIONS, " sliding": SLIDES}
    others = tuple(motion for motion in Motion if motion not in DIRECTED)
    parts = {
        name: tuple(row for row in recordings.rows if row.motion in among)
        for name, among in (tasks | {" without direction": others}).items()
    }
    kept = {name: rows for name, rows in parts.items() if rows}
    if len(kept) == 1:
        return {"": cases}
    return {name: RealCases(replace(recordings, rows=rows)) for name, rows in kept.items()}


def real_cases(folder: str | Path) -> dict[str, RealCases]:
    """Return the labelled recordings of `folder`, or of each folder inside, by folder name.

    Raises:
        UnreadableClip: If there are none, or none with a usable direction.
    """
    found = find_labelled_recordings(folder)
    usable = {one.folder.resolve().name: RealCases(one) for one in found if one.rows}
    if not usable:
        skipped = sum((one.skipped for one in found), Counter())
        if not skipped:
            raise UnreadableClip(
                f"{folder}: the tables of windows hold no row; write one row per motion."
            )
        raise UnreadableClip(
            f"{folder}: no row has a usable direction (left out: {dict(skipped)}); expected one of "
            f"{', '.join(Motion)}."
        )
    return usable
