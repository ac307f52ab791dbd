"""How long a run has taken, those parts before an interruption included."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from geotlm_lm.core.files import write_text_atomically

SECONDS_FILE = "seconds.txt"


@contextmanager
def clock(out: Path) -> Iterator[Callable[[], float]]:
    """Give the seconds this run has taken, those before an interruption included."""
    path, started = out / SECONDS_FILE, time.monotonic()
    before = float(path.read_text()) if path.exists() else 0.0

    def seconds() -> float:
        return before + time.monotonic() - started

    try:
        yield seconds
    finally:
        write_text_atomically(path, f"{seconds():.1f}\n")
