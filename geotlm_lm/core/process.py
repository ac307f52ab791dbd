"""What a long run needs of its process: whole steps, quiet children, cores, progress."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from multiprocessing import resource_tracker
from typing import Any, Protocol

from threadpoolctl import OpenBLASController, ThreadpoolController


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


class _OneBlasThread:
    """Holds numpy's products to one thread while any thread of the process wants it."""

    def __init__(self) -> None:
        self._lock, self._wanted = threading.Lock(), 0
        self._limit: Any = None

    def enter(self) -> None:
        with self._lock:
            if not self._wanted:
                OpenBLASController.clear_controlling_thread(force=True)
                self._limit = _blas().limit(limits=1)
            self._wanted += 1

    def leave(self) -> None:
        with self._lock:
            self._wanted -= 1
            if not self._wanted:
                # Only the thread that set a limit may lift it, which may not be the last to leave.
                OpenBLASController.clear_controlling_thread(force=True)
                self._limit.restore_original_limits()


@lru_cache(maxsize=1)
def _blas() -> ThreadpoolController:
    return ThreadpoolController().select(user_api="blas")


_ONE_BLAS_THREAD = _OneBlasThread()


@contextmanager
def in_one_thread() -> Iterator[None]:
    """Let numpy and torch compute in the calling thread alone.

    Handing out parts of products as small as a clip's or a question's takes longer than the
    products, and beside busy cores ten times longer: the threads spin while they wait for each
    other.
    """
    torch = sys.modules.get("torch")
    before = 1 if torch is None else torch.get_num_threads()  # of the calling thread
    if before > 1:
        torch.set_num_threads(1)
    _ONE_BLAS_THREAD.enter()
    try:
        yield
    finally:
        _ONE_BLAS_THREAD.leave()
        if before > 1:
            torch.set_num_threads(before)


def usable_cores() -> int:
    """Return how many cores this process may run on, which a container may have limited."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
