"""Frames on their way from a source that does not wait to a reader that may be slow.

They go through a bounded buffer: when the reader falls behind, the oldest are dropped and counted.
"""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import Stalled

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


SILENT_S = 2.0
"""Seconds without a frame after which a live source is told to be silent, and again after twice as
many each time."""

STALLED_S = 10.0
"""Seconds without a frame after which nobody waits for more."""


@dataclass(frozen=True)
class Patience:
    """How long the silence of a source is borne, and who hears of it.

    Args:
        stalled_s: Seconds without a frame after which its reader is told that it has stalled;
            infinite for one that may pause, as a recording may.
        tell: Called with the seconds without a frame so far, at rising intervals.
    """

    stalled_s: float = math.inf
    tell: Callable[[float], None] | None = None

    def moments_s(self) -> Iterator[float]:
        """Yield the seconds of silence at which there is something to do."""
        yield from rising_s() if self.tell else ()


def rising_s() -> Iterator[float]:
    """Yield the seconds after which to tell of what goes on, and tell of it again."""
    return (SILENT_S * 2**number for number in count())


class LatestFrames:
    """A buffer between a source that does not wait and a reader that may be slow.

    Args:
        capacity: Frames that may wait; beyond it the oldest is dropped.
        patience: With the source.
        name: Of the source.
    """

    def __init__(
        self,
        capacity: int = BUFFERED_FRAMES,
        patience: Patience | None = None,
        name: str = "The source",
    ) -> None:
        self._name = name
        self._waiting: deque[StreamFrame] = deque()
        self._capacity, self._is_closed = capacity, False
        self._patience = patience or Patience()
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
        """Yield frames in order, waiting for each, until the stream is closed.

        Raises:
            Stalled: If nothing comes for as long as the patience lasts.
        """
        while True:
            self._wait()
            with self._changed:
                if not self._waiting:
                    if self._error is not None:
                        raise self._error
                    return
                frame = self._waiting.popleft()
            yield frame

    def _wait(self) -> None:
        began, moments_s = time.monotonic(), self._patience.moments_s()
        due_s = next(moments_s, math.inf)
        while True:
            with self._changed:
                if self._waiting or self._is_closed:
                    return
                silent_s = time.monotonic() - began
                next_s = min(due_s, self._patience.stalled_s) - silent_s
                if next_s > 0:  # half a second at most: a signal must be heard
                    self._changed.wait(timeout=min(next_s, 0.5))
                    continue
            if due_s <= min(silent_s, self._patience.stalled_s):
                self._patience.tell(due_s)
                due_s = next(moments_s)
            else:
                raise Stalled(
                    f"{self._name} has given no frame for {self._patience.stalled_s:g} s; check "
                    f"its cable, close other programs that use it, and start again, or wait "
                    f"longer by --stalled-after."
                )


class Unwaiting(ABC):
    """A source that does not wait for its reader: a thread brings the frames into a buffer.

    Args:
        name: What errors call it.
        buffer: That it fills; None for one that waits without end.
    """

    is_live = False
    """Whether its frames are taken now, so that one that does not come is missing."""

    def __init__(self, name: str, buffer: LatestFrames | None = None) -> None:
        self.name, self._buffer, self._is_read = name, buffer or LatestFrames(), True

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
