"""Clips of a folder of recordings beyond its labelled windows: whole, untouched, pressed in only.

Of clips without a direction it counts how often one is claimed all the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from geotlm_lm.benchmarks.cases.recordings import smallest_task
from geotlm_lm.benchmarks.cases.semi_real import as_image, read_touched
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion, reverse
from geotlm_lm.data.touch_table import (
    FIRST_IDLE,
    SURELY_IDLE,
    DirectedRow,
    TouchRow,
    UntouchedRow,
)
from geotlm_lm.recordings.idle import find_idle
from geotlm_lm.recordings.read import read_clip

WINDOW_S = 1.0
"""Length of the windows that recordings without a visible contact are cut into."""


@dataclass(frozen=True)
class WholeRecordings:
    """Each recording read whole, beside its idle gel where that is found in it.

    Every method is given all its frames. Where something turns both ways in a recording, the label
    is that of its main motion.

    Args:
        rows: The recordings.
    """

    rows: Sequence[DirectedRow]

    @property
    def among(self) -> tuple[Motion, ...]:
        """The smallest task that holds every label."""
        return smallest_task(row.motion for row in self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Case]:
        for row in self.rows:
            clip = read_clip(row.path)
            if clip.background is None:
                clip = replace(clip, background=find_idle(clip))
            yield Case(clip, row.motion, row.object_id, row.object_family, {})


@dataclass
class NoContactWindows:
    """Windows of one second of recordings in which nothing is seen to touch, one after another.

    Soft things do press on the gel in some of them: it changes, but no imprint shows.

    Args:
        rows: The recordings.
        too_short: Recordings without a whole window, filled while iterating.
    """

    rows: Sequence[UntouchedRow]
    too_short: int = field(default=0)

    def __iter__(self) -> Iterator[Case]:
        self.too_short = 0
        for row in self.rows:
            frames = read_clip(row.path).frames
            length = max(round(WINDOW_S * row.fps), FRAME_COUNT)
            begin = FIRST_IDLE + SURELY_IDLE
            self.too_short += len(frames) < begin + length
            idle = as_image(frames[FIRST_IDLE:begin].mean(axis=0)) if len(frames) > 1 else None
            for first in range(begin, len(frames) - length + 1, length):
                numbers = _evenly(range(first, first + length))
                clip = Clip(frames[numbers], fps=row.fps, background=idle, name=row.path.name)
                yield Case(clip, Motion.NONE, row.object_id, row.object_family, {})


@dataclass
class PressedIn:
    """Four frames of each recording from just before the touch to just before the first turn.

    Args:
        rows: The recordings; those whose turn begins too soon are passed over.
    """

    rows: Sequence[TouchRow]

    def __len__(self) -> int:
        return sum(row.pressing is not None for row in self.rows)

    def __iter__(self) -> Iterator[Case]:
        for row in self.rows:
            if row.pressing is None:
                continue
            frames, idle = read_touched(row)
            numbers = _evenly(row.pressing)
            clip = Clip(frames[numbers], fps=row.fps, background=as_image(idle), name=row.path.name)
            yield Case(clip, Motion.PRESS, row.object_id, row.object_family, {})


def backwards(cases: Iterable[Case]) -> Iterator[Case]:
    """Yield each clip played backwards."""
    for case in cases:
        yield replace(case, clip=case.clip.reversed(), motion=reverse(case.motion))


def _evenly(frames: range) -> list[int]:
    return np.linspace(frames[0], frames[-1], FRAME_COUNT).round().astype(int).tolist()
