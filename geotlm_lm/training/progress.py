"""One line on stderr: what runs, how far, how long it still takes."""

from __future__ import annotations

import sys
import time
from typing import TextIO

REFRESH_S = 0.5
QUIET_REFRESH_S = 20.0
"""Where stderr is a file or a pipe, one line every this many seconds."""


class Progress:
    """Report one stage of known length.

    Args:
        stage: Name of the stage.
        total: Units of work.
        done: Units already done in an earlier, interrupted run.
        stream: Where to write; stderr by default.
    """

    def __init__(self, stage: str, total: int, done: int = 0, stream: TextIO | None = None) -> None:
        self.stage, self.total = stage, total
        self._resumed_at, self._started = done, time.monotonic()
        self._stream = stream or sys.stderr
        self._is_terminal = self._stream.isatty()
        self._last_shown = -1e9

    def show(self, done: int, note: str = "") -> None:
        """Report that `done` of the total units are finished; rate-limited."""
        now = time.monotonic()
        pause = REFRESH_S if self._is_terminal else QUIET_REFRESH_S
        if now - self._last_shown < pause and done < self.total:
            return
        self._last_shown = now
        elapsed = now - self._started
        share = f"{done}/{self.total} ({100 * done / max(self.total, 1):.0f} %)"
        line = f"{self.stage}: {share}, {_duration(elapsed)}"
        if self._resumed_at < done < self.total:
            left = elapsed * (self.total - done) / (done - self._resumed_at)
            line += f", {_duration(left)} left"
        line += f", {note}" if note else ""
        ends_line = not self._is_terminal or done >= self.total
        start = "\r\x1b[K" if self._is_terminal else ""
        self._stream.write(start + line + ("\n" if ends_line else ""))
        self._stream.flush()


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
