"""Frames on their way from a source that does not wait to a reader that may be slow.

They go through a bounded buffer: when the reader falls behind, the oldest are dropped and counted.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from geotlm_lm.core.clip import Frames

BUFFERED_FRAMES = 25
"""Frames that may wait: a second of a GelSight Mini; after that an answer is no longer live."""

THREAD_END_S = 1.0
"""Seconds the thread that brings the frames is waited for: one that is inside a decoder when Python
ends aborts the process, and no frame takes as long."""


@dataclass(frozen=True, eq=False)
class StreamFrame:
    """One frame of a stream.

    Args:
        image: uint8 RGB, shape (rows, columns, 3).
        time_s: When it was taken, seconds into the stream.
        number: Of the frame in the recording, or of those that the camera gave, from 0.
    """

    image: Frames
    time_s: float
    number: int


class LatestFrames:
    """A buffer between a source that does not wait and a reader that may be slow.

    Args:
        capacity: Frames that may wait; beyond it the oldest is dropped.
    """

    def __init__(self, capacity: int = BUFFERED_FRAMES) -> None:
        self._waiting: deque[StreamFrame] = deque()
        self._capacity, self._is_closed = capacity, False
        self._changed = threading.Condition()
        self.dropped = 0
        self._error: Exception | None = None

    def put(self, frame: StreamFrame) -> None:
        """Add a frame; never waits."""
        with self._changed:
            self._waiting.append(frame)
            if len(self._waiting) > self._capacity:
                self._waiting.popleft()
                self.dropped += 1
            self._changed.notify()

    def close(self, error: Exception | None = None) -> None:
        """End the stream; what waits is still read, then `error` is raised to the reader."""
        with self._changed:
            self._is_closed, self._error = True, error
            self._changed.notify()

    def __iter__(self) -> Iterator[StreamFrame]:
        """Yield frames in order, waiting for each, until the stream is closed."""
        while True:
            with self._changed:
                while not self._waiting and not self._is_closed:
                    self._changed.wait(timeout=0.5)
                if not self._waiting:
                    if self._error is not None:
                        raise self._error
                    return
                frame = self._waiting.popleft()
            yield frame


class Unwaiting(ABC):
    """A source that does not wait for its reader: a thread brings the frames into a buffer.

    Args:
        name: What errors call it.
    """

    def __init__(self, name: str) -> None:
        self.name, self._buffer, self._is_read = name, LatestFrames(), True

    @property
    def dropped(self) -> int:
        """Frames the reader was too slow for."""
        return self._buffer.dropped

    def __iter__(self) -> Iterator[StreamFrame]:
        """Yield the newest frames until the reader stops or they end."""
        bringer = threading.Thread(target=self._bring_all, daemon=True)
        bringer.start()
        try:
            yield from self._buffer
        finally:
            self._is_read = False
            bringer.join(THREAD_END_S)

    def _bring_all(self) -> None:
        try:
            self._bring()
        except Exception as error:  # whatever it is, the reader must not wait for ever
            self._buffer.close(error)
        else:
            self._buffer.close()

    @abstractmethod
    def _bring(self) -> None:
        """Put frames into the buffer until they end or nobody reads."""
