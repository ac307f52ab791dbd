"""A camera that goes on giving frames in which nothing is to be seen any more."""

from __future__ import annotations

import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.recordings.latest_frames import rising_s
from geotlm_lm.recordings.legible import DARK_GREY

EVERY_PX = 8
"""Of so many rows and columns one is looked at: noise leaves not all of them as they are."""


class StuckPicture:
    """Notices that frames are all the same, or black, for some time.

    Attributes:
        note: What was last told of it; empty once there is something to be seen again.
    """

    def __init__(self) -> None:
        self._before: Frames | None = None
        self.note = ""
        self._kind, self._since_s, self._moments_s = "", 0.0, rising_s()
        self._due_s = next(self._moments_s)

    def after(self, image: Frames, time_s: float) -> str:
        """Take in the next frame, and return a sentence where it is time for one, at rising times.

        Args:
            image: uint8 RGB.
            time_s: When it was taken.
        """
        seen = image[::EVERY_PX, ::EVERY_PX].copy()
        is_same = self._before is not None and np.array_equal(seen, self._before)
        kind = "black" if seen.max() <= DARK_GREY else "all the same" if is_same else ""
        self._before = seen
        if kind != self._kind or not kind:
            self.note, self._kind = "", kind
            self._since_s, self._moments_s = time_s, rising_s()
            self._due_s = next(self._moments_s)
        if not kind or time_s - self._since_s < self._due_s:
            return ""
        told_s, self._due_s = self._due_s, next(self._moments_s)
        self.note = (
            f"The camera's frames have been {kind} for {told_s:g} s; check its cable and the "
            f"sensor's lights."
        )
        return self.note
