"""What a long run needs of its process: whole steps, quiet children, cores, progress."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Protocol


class Progress(Protocol):
    """Called whenever a part of a run is done."""

    def __call__(self, what: str, done: int, total: int) -> None:
        """Take in that `done` of `total` units of a stage are done, also in an earlier run.

        After a comma `what` may hold what changes within the stage, such as the loss.
        """


def silent(what: str, done: int, total: int) -> None:
    """Show nothing."""


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


ENDING = frozenset({signal.SIGINT, signal.SIGTERM})
"""Signals that ask a process to end."""


@contextmanager
def children_without_interrupts() -> Iterator[None]:
    """Start processes inside that never see Ctrl-C: it is their parent's to end them.

    A terminal sends Ctrl-C to every process of a command; each worker would print a trace. What
    asks the parent to end meanwhile waits until they are started, and is not lost. They inherit
    that SIGTERM waits as well, and let it through by `endable`.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    resource_tracker.ensure_running()  # which lets signals through again as it starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def endable() -> None:
    """Let SIGTERM end this process, which its parent started while it waited."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})


THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def one_thread_in_children() -> Iterator[None]:
    """Start processes inside with one BLAS thread each: it is read when numpy is first imported."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def usable_cores() -> int:
    """Return how many cores this process may run on, which a container may have limited."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
