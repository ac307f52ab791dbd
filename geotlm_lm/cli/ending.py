"""A request to end, as `kill`, `timeout` and service managers send it, closes files like Ctrl-C."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def ended_in_order() -> Iterator[None]:
    """Turn SIGTERM into an interruption; after the block the process ends of the signal itself.

    Without it a video that is being written would stay without its index, which no player reads.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    asked, owner = [], os.getpid()

    def end(number: int, _: object) -> None:
        if asked or os.getpid() != owner:  # asked twice, or a copy of the process made to work
            _end_by(number)
        asked.append(number)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before or signal.SIG_DFL)  # None: set outside Python
        if asked:
            _end_by(asked[0])


def _end_by(number: int) -> None:
    """End this process as the signal would have; whoever sent it looks for that."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
