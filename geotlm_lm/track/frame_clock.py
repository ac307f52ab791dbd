"""When frames were taken: times that rise, whatever a source says of them."""

from __future__ import annotations

import math
from collections import deque
from statistics import median

GAP_S, GAP_STEPS = 0.3, 4.0
"""Time between two frames, and the same in usual ones, from which on frames are missed."""

STEADY_STEPS = 15
"""Steps that the usual one is the median of."""

SET_BACK_FRAMES = 3
"""Frames in a row, rising among themselves, whose times lie back: then the clock was set."""


class FrameClock:
    """Turns the times of a source into times that rise."""

    def __init__(self) -> None:
        self._last_s, self._shift_s = -math.inf, 0.0
        self._steps: deque[float] = deque(maxlen=STEADY_STEPS)
        self._back: list[float] = []
        self._late, self._set_back, self._gaps = 0, -1, 0
        self._longest_s, self._after_gap = 0.0, -1

    def time_of(self, source_s: float, number: int) -> float | None:
        """Return when a frame was taken, in s, or None for a frame that is to be left out."""
        time_s = source_s + self._shift_s
        if not math.isfinite(time_s):
            self._late += 1
            return None
        if time_s <= self._last_s:
            if not self._is_set_back(source_s):
                self._late += 1
                return None
            # Those that were left out until the clock was known to be set took their time too.
            time_s = self._last_s + len(self._back) * self._usual_s
            self._shift_s, self._set_back = time_s - source_s, number
        elif self._steps:
            self._watch_for_gap(time_s - self._last_s, number)
        if math.isfinite(self._last_s):
            self._steps.append(time_s - self._last_s)
        self._last_s, self._back = time_s, []
        return time_s

    def notes(self) -> list[str]:
        """Return what was amiss, one sentence each."""
        notes = []
        if self._late:
            notes.append(f"{self._late} frames were no later than those before and left out.")
        if self._set_back >= 0:
            notes.append(
                f"The frames' times go back before frame {self._set_back}; they count on from "
                f"there."
            )
        if self._gaps:
            often = "" if self._gaps == 1 else f", and for less {self._gaps - 1} times more"
            notes.append(
                f"No frame came for {self._longest_s:.2f} s before frame {self._after_gap}{often}: "
                f"what happened meanwhile is not known."
            )
        return notes

    @property
    def _usual_s(self) -> float:
        return median(self._steps) if self._steps else 0.04

    def _is_set_back(self, source_s: float) -> bool:
        rises = self._back and source_s > self._back[-1]
        self._back = [*self._back, source_s] if rises else [source_s]
        return len(self._back) >= SET_BACK_FRAMES

    def _watch_for_gap(self, step_s: float, number: int) -> None:
        if step_s <= max(GAP_S, GAP_STEPS * self._usual_s):
            return
        self._gaps += 1
        if step_s > self._longest_s:
            self._longest_s, self._after_gap = step_s, number
