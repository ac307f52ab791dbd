"""What Ctrl-C and SIGTERM may break off and must wait for, whatever work it is."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import active_children, parent_process
from multiprocessing.process import BaseProcess


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


@contextmanager
def children_killed_on_error() -> Iterator[Callable[[], None]]:
    """End the processes started inside at once if the block is broken off.

    Yields what a block that lets others work in between calls once its own are started: processes
    that these others start are theirs.
    """
    before = set(active_children())
    own: list[set[BaseProcess]] = []

    def all_started() -> None:
        own.append(set(active_children()) - before)

    try:
        yield all_started
    except BaseException:
        alive = set(active_children())
        for child in alive & own[0] if own else alive - before:
            child.terminate()
        raise


def end_if_orphaned() -> None:
    """End this worker process if its parent was killed: a pool's workers would wait for ever."""
    parent = parent_process()
    if parent is not None and not parent.is_alive():
        os._exit(1)
