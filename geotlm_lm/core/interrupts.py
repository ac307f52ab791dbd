"""What Ctrl-C and SIGTERM may break off and must wait for, whatever work it is."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uninterrupted_step() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM wait until the block is done: half a step must not be saved."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python delivers signals to the main thread only.
        return
    caught: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: caught.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler or signal.SIG_DFL)  # None: it was set outside Python
    if caught:
        signal.raise_signal(caught[0])


@contextmanager
def children_without_interrupts() -> Iterator[None]:
    """Start processes inside that never see Ctrl-C: it is their parent's to end them.

    A terminal sends Ctrl-C to every process of a command; each worker would print a trace.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # a started program inherits this
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
