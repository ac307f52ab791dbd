"""How far a long command is, on stderr: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import atexit
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TextIO

from geotlm_lm.core.process import Progress

if TYPE_CHECKING:
    from rich.progress import Progress as Bars
    from rich.progress import TaskID

REPORT_EVERY_S = 2.0
"""A wait longer than this shows how far it is."""

RATE_AFTER_S = 0.5
"""Two processes that end their first parts together would else seem to take no time at all."""


def progress_on_stderr(unit: str = "clips") -> Progress:
    """Return what shows on stderr how far a command is.

    Args:
        unit: What is counted; empty where the stage says it.
    """
    return ProgressBars(sys.stderr) if sys.stderr.isatty() else ProgressLines(unit)


class ProgressLines:
    """Lines for a file or a pipe: at most one every `REPORT_EVERY_S`, and one at each end.

    From the second report of a stage on they tell the rate. It counts from the first: neither
    starting up nor what an earlier run left behind is in it.

    Args:
        unit: What is counted; empty where the stage says it.
        clock: Seconds from any moment on.
    """

    def __init__(self, unit: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._unit, self._clock = unit, clock
        self._shown_at = clock()
        self._stage: tuple[str, int] | None = None
        self._first = (0, 0.0)

    def __call__(self, what: str, done: int, total: int) -> None:
        """Print a line if it is time to."""
        now, stage = self._clock(), (_stage_of(what), total)
        if stage != self._stage:
            self._stage, self._first = stage, (done, now)
        if done != total and now - self._shown_at <= REPORT_EVERY_S:
            return
        self._shown_at = now
        before, began = self._first
        seconds = now - began
        unit = f" {self._unit}" if self._unit else ""
        rate = f", {(done - before) / seconds:.1f}/s" if seconds > RATE_AFTER_S else ""
        print(f"{what}: {done} of {total}{unit}{rate}", file=sys.stderr, flush=True)


class ProgressBars:
    """One bar per stage on a terminal, each left standing once it is full.

    Args:
        stream: The terminal.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._bars: Bars | None = None
        self._task: TaskID | None = None
        self._stage: tuple[str, int] | None = None

    def __call__(self, what: str, done: int, total: int) -> None:
        """Move the bar of the stage, or begin one."""
        stage = (_stage_of(what), total)
        if self._bars is None or stage != self._stage:
            self.close()
            self._bars, self._stage = self._begun(), stage
            self._task = self._bars.add_task(what, total=total, completed=done)
        self._bars.update(self._task, description=what, completed=done)
        if done >= total:
            self.close()

    def close(self) -> None:
        """Leave the bar as it stands and give the cursor back."""
        if self._bars is not None:
            self._bars.stop()
            atexit.unregister(self.close)
            self._bars = None

    def _begun(self) -> Bars:
        # Imported only now: an answer must not wait for it.
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )
        from rich.progress import Progress as Bars

        bars = Bars(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(file=self._stream),
        )
        atexit.register(self.close)  # an error may end the stage before it is full
        bars.start()
        return bars


def _stage_of(what: str) -> str:
    return what.partition(",")[0]
