"""Parts of a long run done by processes of this machine, one thread each."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children
from multiprocessing.process import BaseProcess
from typing import TypeVar

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.process import (
    children_without_interrupts,
    endable,
    in_one_thread,
    one_thread_in_children,
)

Part, Result = TypeVar("Part"), TypeVar("Result")
Hire = Callable[[int], list[ProcessPoolExecutor]]
"""Starts so many workers."""


def map_by_processes(
    work: Callable[[Part], Result],
    parts: Sequence[Part],
    workers: int,
    lost: Callable[[Part], Result] | None,
    *,
    is_here: bool,
) -> Iterator[tuple[Part, Result]]:
    """Yield each part with what `work` returns of it; arguments as of `Workers.map`.

    A part whose process was ended is done last, with no other beside it: what the system ends for
    want of memory need not be what took it.

    Raises:
        GeoTLMError: If a part ended its worker twice and nothing stands for it, or if no worker
            can be started.
    """
    if not parts or (is_here and min(workers, len(parts)) <= 1):
        for part in parts:
            with one_thread():
                result = work(part)
            yield part, result
        return
    suspects: list[Part] = []
    with _hiring() as hire:
        yield from _map_by_many(work, parts, hire(min(workers, len(parts))), hire, suspects)
    for part in suspects:
        with _hiring() as hire:
            future = hire(1)[0].submit(work, part)
            is_lost = isinstance(future.exception(), BrokenProcessPool)
            if is_lost and lost is None:
                raise GeoTLMError(
                    "A worker was ended from outside, most likely for want of memory; run this "
                    "again with fewer workers, what was finished is kept."
                )
            yield part, lost(part) if is_lost else future.result()


def _map_by_many(
    work: Callable[[Part], Result],
    parts: Sequence[Part],
    idle: list[ProcessPoolExecutor],
    hire: Hire,
    suspects: list[Part],
) -> Iterator[tuple[Part, Result]]:
    """Yield what workers return, each of one part at a time; add parts that ended theirs."""
    waiting = deque(parts)
    busy: dict[Future[Result], tuple[ProcessPoolExecutor, Part]] = {}

    def submit() -> None:
        while waiting and idle:
            worker = idle.pop()
            try:
                busy[worker.submit(work, waiting[0])] = worker, waiting[0]
                waiting.popleft()
            except BrokenProcessPool:  # ended while it had nothing to do
                idle.extend(hire(1))

    submit()
    while busy:
        future = wait(busy, return_when=FIRST_COMPLETED).done.pop()
        worker, part = busy.pop(future)
        has_ended = isinstance(future.exception(), BrokenProcessPool)
        if has_ended:
            suspects.append(part)
        idle += [worker] if not has_ended else hire(1) if waiting else []
        submit()  # before the caller sees the result: a worker need not wait for it
        if not has_ended:
            yield part, future.result()


@contextmanager
def _hiring() -> Iterator[Hire]:
    """Yield what starts workers, each a pool of one process: where that ends, its part is known."""
    pools: list[ProcessPoolExecutor] = []
    processes: set[BaseProcess] = set()

    def hire(count: int) -> list[ProcessPoolExecutor]:
        before = set(active_children())
        # Spawned, not forked: a forked process inherits torch's threads in an unusable state.
        context = multiprocessing.get_context("spawn")
        new = [ProcessPoolExecutor(1, context, _prepare_worker) for _ in range(count)]
        pools.extend(new)
        try:
            with children_without_interrupts(), one_thread_in_children():
                begun = [pool.submit(os.getpid) for pool in new]
        finally:
            processes.update(set(active_children()) - before)
        try:
            for future in begun:
                future.result()
        except BrokenProcessPool as error:
            raise GeoTLMError(
                "A worker was ended before it had begun, most likely for want of memory; run this "
                "again with fewer workers, what was finished is kept."
            ) from error
        return new

    try:
        yield hire
    except BaseException:
        for process in processes & set(active_children()):
            process.terminate()
        raise
    finally:
        for pool in pools:
            pool.shutdown(cancel_futures=True)


@contextmanager
def one_thread() -> Iterator[None]:
    """Let numpy, torch and OpenCV use one thread: how many there are decides a sum's last bits."""
    import cv2
    import torch  # noqa: F401 -- what is imported only inside would keep all its threads

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with in_one_thread():
            yield
    finally:
        cv2.setNumThreads(before)


def _prepare_worker() -> None:
    endable()
    import cv2
    import torch

    def end_with_parent() -> None:
        # A worker whose parent was killed would wait for its next part for ever.
        multiprocessing.parent_process().join()
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
