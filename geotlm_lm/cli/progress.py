"""How far a long command is, on stderr: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import atexit
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TextIO

from geotlm_lm.core.process import Progress

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

REPORT_EVERY_S = 2.0
"""A wait longer than this shows how far it is."""

RATE_AFTER_S = 0.5
"""Two processes that end their first parts together would else seem to take no time at all."""


def progress_on_stderr(unit: str = "clips") -> Progress:
    """Return what shows on stderr how far a command is; `unit` is counted, empty in stages' names.

    What follows a comma in a stage's name may change within the stage.
    """
    return ProgressBars(sys.stderr) if sys.stderr.isatty() else ProgressLines(unit)


def print_notes(*notes: str) -> None:
    """Print to stderr what was guessed or passed over, a line each."""
    for note in notes:
        print(f"note: {note}", file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Return a time in words, in the unit that suits it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


class ProgressLines:
    """Lines for a file or a pipe: at most one every `REPORT_EVERY_S`, and one at each end.

    From the second report of a stage on they tell the rate and the time left. The rate counts from
    the first: neither starting up nor what an earlier run left behind is in it. The clock tells
    seconds.
    """

    def __init__(self, unit: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._unit, self._clock = f" {unit}" if unit else "", clock
        self._shown_at = clock()
        self._stage: tuple[str, int] | None = None
        self._first = (0, 0.0)

    def __call__(self, what: str, done: int, total: int) -> None:
        """Print a line if it is time to."""
        now, stage = self._clock(), (what.partition(",")[0], total)
        if stage != self._stage:
            self._stage, self._first = stage, (done, now)
        if done != total and now - self._shown_at <= REPORT_EVERY_S:
            return
        self._shown_at = now
        before, began = self._first
        seconds = now - began
        rate = (done - before) / seconds if seconds > RATE_AFTER_S else 0.0
        pace = f", {rate:.1f}/s" if rate else ""
        if rate and done < total:
            pace += f", {duration((total - done) / rate)} left"
        print(f"{what}: {done} of {total}{self._unit}{pace}", file=sys.stderr, flush=True)


class ProgressBars:
    """One bar per stage on a terminal, each left standing once it is full."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._bar: Bar | None = None
        self._stage: tuple[str, int] | None = None

    def __call__(self, what: str, done: int, total: int) -> None:
        """Move the bar of the stage, or begin one."""
        stage = (what.partition(",")[0], total)
        if self._bar is None or stage != self._stage:
            self.close()
            self._begin(what, done, total)
            self._stage = stage
        self._bar.update(self._bar.task_ids[0], description=what, completed=done)
        if done >= total:
            self.close()

    def close(self) -> None:
        """Leave the bar as it stands and give the cursor back."""
        if self._bar is not None:
            self._bar.stop()
            atexit.unregister(self.close)
            self._bar = None

    def _begin(self, what: str, done: int, total: int) -> None:
        # Imported only now: an answer must not wait for it.
        from rich import progress as rich
        from rich.console import Console

        columns = (rich.BarColumn(), rich.MofNCompleteColumn(), rich.TimeElapsedColumn(),
                   rich.TimeRemainingColumn())  # fmt: skip
        words = rich.TextColumn("{task.description}", markup=False)
        self._bar = rich.Progress(words, *columns, console=Console(file=self._stream))
        self._bar.add_task(what, total=total, completed=done)
        atexit.register(self.close)  # an error may end the stage before it is full
        self._bar.start()
