"""Clips of a folder of recordings beyond its labelled windows: whole, untouched, pressed in only.

Of clips without a direction it counts how often one is claimed all the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from geotlm_lm.benchmarks.cases.semi_real import as_image, evenly, touched_case
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


def whole_recordings(rows: Iterable[DirectedRow]) -> Iterator[Case]:
    """Yield each recording read whole, beside its idle gel where that is found in it.

    Every method is given all its frames. Where something turns both ways in a recording, the label
    is that of its main motion.
    """
    for row in rows:
        clip = read_clip(row.path)
        if clip.background is None:
            clip = replace(clip, background=find_idle(clip))
        yield Case(clip, row.motion, row.object_id, row.object_family)


@dataclass
class NoContactWindows:
    """Windows of one second of recordings in which nothing is seen to touch, one after another.

    Soft things do press on the gel in some of them: it changes, but no imprint shows.

    Args:
        rows: The recordings.
        too_short: Recordings without a whole window, filled while they are read.
    """

    rows: Sequence[UntouchedRow]
    too_short: int = field(default=0)

    def __call__(self) -> Iterator[Case]:
        """Yield the windows."""
        self.too_short = 0
        for row in self.rows:
            frames = read_clip(row.path).frames
            length = max(round(WINDOW_S * row.fps), FRAME_COUNT)
            begin = FIRST_IDLE + SURELY_IDLE
            self.too_short += len(frames) < begin + length
            idle = as_image(frames[FIRST_IDLE:begin].mean(axis=0)) if len(frames) > 1 else None
            for first in range(begin, len(frames) - length + 1, length):
                numbers = evenly(range(first, first + length))
                clip = Clip(frames[numbers], fps=row.fps, background=idle, name=row.path.name)
                yield Case(clip, Motion.NONE, row.object_id, row.object_family)


def pressed_in(rows: Iterable[TouchRow]) -> Iterator[Case]:
    """Yield four frames of each recording from just before the touch to just before the first turn.

    Those whose turn begins too soon are passed over.
    """
    for row in rows:
        if row.pressing is not None:
            yield touched_case(row, row.pressing, Motion.PRESS)


def backwards(cases: Iterable[Case]) -> Iterator[Case]:
    """Yield each clip played backwards."""
    for case in cases:
        yield replace(case, clip=case.clip.reversed(), motion=reverse(case.motion))
