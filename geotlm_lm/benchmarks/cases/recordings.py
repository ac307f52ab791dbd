"""Windows of labelled real recordings: four frames and pairs, and as other sensors show them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, turn_by_quarter
from geotlm_lm.data.labelled_recordings import (
    LabelledRecordings,
    WindowRow,
    find_labelled_recordings,
)
from geotlm_lm.data.touch_table import DirectedRow

Shown = Callable[[Clip, Motion], tuple[Clip, Motion]]
"""Takes a clip and its motion, returns how it is shown and its motion there."""


def window_cases(recordings: LabelledRecordings) -> Iterator[Case]:
    """Yield each window as four frames and as a pair, both forwards and backwards."""
    for window in recordings.windows(frames=("four", "pair"), backwards=True):
        tags = {
            "frames": window.frames,
            "played": "backwards" if window.is_backwards else "forwards",
            "fps": "unknown" if window.clip.fps is None else f"{window.clip.fps:g}",
        }
        row = window.row
        yield Case(window.clip, window.motion, row.object_id, row.object_family, tags)


def four_frames(recordings: LabelledRecordings, shown: Shown) -> Iterator[Case]:
    """Yield the four-frame windows, both ways, as something else shows them."""
    for window in recordings.windows(frames=("four",), backwards=True):
        (clip, motion), row = shown(window.clip, window.motion), window.row
        yield Case(clip, motion, row.object_id, row.object_family)


def task_of(rows: Iterable[WindowRow | DirectedRow]) -> tuple[Motion, ...]:
    """Return the smallest task that holds every label."""
    held = {row.motion for row in rows}
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


def by_task(recordings: LabelledRecordings) -> dict[str, LabelledRecordings]:
    """Split recordings whose labels are of more than one task, so that each is asked as a task.

    Returns:
        What to add to the name -> the recordings of that part; nothing is added where all labels
        are of one task.
    """
    tasks = {" rotation": ROTATIONS, " sliding": SLIDES}
    others = tuple(motion for motion in Motion if motion not in DIRECTED)
    parts = {
        name: tuple(row for row in recordings.rows if row.motion in among)
        for name, among in (tasks | {" without direction": others}).items()
    }
    kept = {name: rows for name, rows in parts.items() if rows}
    if len(kept) == 1:
        return {"": recordings}
    return {name: replace(recordings, rows=rows) for name, rows in kept.items()}


def real_recordings(folder: Path | None) -> dict[str, LabelledRecordings]:
    """Return the labelled recordings of `folder`, or of each folder inside, by folder name.

    Without a folder there are none.

    Raises:
        UnreadableClip: If there are none, or none with a usable direction.
    """
    if folder is None:
        return {}
    found = find_labelled_recordings(folder)
    usable = {one.folder.resolve().name: one for one in found if one.rows}
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
