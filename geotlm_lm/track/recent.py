"""The last seconds of a stream, kept for a question about a motion that is over."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.track.events import Event

KEPT_FRAMES = 64
"""Frames kept: 15 MB at 320x240."""

APART_S = 0.08
"""Time between two of them at the least, so that they reach back over 5 s."""


class RecentFrames:
    """A short ring of frames.

    Args:
        fps: Frames per second of the stream.
    """

    def __init__(self, fps: float) -> None:
        self._fps = fps
        self._kept: deque[tuple[int, Frames]] = deque(maxlen=KEPT_FRAMES)
        self._last_s = -math.inf

    def add(self, frame: Frames, number: int, time_s: float) -> None:
        """Keep a frame, unless the last one kept was taken just before."""
        if time_s - self._last_s >= APART_S - JITTER_S:
            self._kept.append((number, frame))
            self._last_s = time_s

    def clip_of(self, event: Event, idle: Frames) -> Clip | None:
        """Return the frames of an event beside the idle gel; None where fewer than two are kept."""
        kept = [one for one in self._kept if event.begin <= one[0] <= event.end]
        if len(kept) < 2:
            return None
        numbers, frames = zip(*kept, strict=True)
        name = f"the {event.kind.value} of the stream"
        return Clip(np.stack(frames), self._fps, idle, name, numbers)


JITTER_S = 0.002
"""A frame this much early still counts as on time."""
