"""Whole recordings with a labelled direction: idle, press, motion and release, as users hand them.

Nobody says where the motion is: the product's own choice of frames is judged with the method. Knows
clips, not methods.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion
from geotlm_lm.data.touch_table import DirectedRow
from geotlm_lm.experiments.compare import Case
from geotlm_lm.recordings.choose import choose_frames
from geotlm_lm.recordings.read import read_clip


@dataclass(frozen=True)
class WholeRecordings:
    """Each recording read whole, as the four frames that an answer would be given of.

    They are chosen once, here, so that every method sees the same four. Where something turns both
    ways in a recording, the label is that of its main motion, and the other way counts as wrong
    even where the chosen frames do show it.

    Args:
        rows: The recordings.
    """

    rows: Sequence[DirectedRow]

    @property
    def among(self) -> tuple[Motion, ...]:
        """The smallest task that holds every label."""
        motions = {row.motion for row in self.rows}
        return next(task for task in (ROTATIONS, SLIDES, DIRECTED) if motions <= set(task))

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Case]:
        for row in self.rows:
            clip = choose_frames(read_clip(row.path))
            yield Case(clip, row.motion, row.object_id, row.object_family, {})
