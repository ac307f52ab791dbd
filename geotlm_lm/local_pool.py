"""Parts of a long run done by processes of this machine, one thread each; knows nothing of them."""

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
from geotlm_lm.core.process import children_without_interrupts, one_thread_in_children

Part, Done = TypeVar("Part"), TypeVar("Done")


def each_done(
    work: Callable[[Part], Done],
    parts: Sequence[Part],
    workers: int,
    lost: Callable[[Part], Done] | None = None,
    *,
    is_here: bool = True,
) -> Iterator[Done]:
    """Yield what `work` returns of every part, in the order in which they are done.

    A part whose process was ended is done last, with no other beside it: what the system ends for
    want of memory need not be what took it.

    Args:
        work: A function of a module: processes import it.
        parts: What is to be done, each independent of the others.
        workers: Processes.
        lost: As of `Workers.each_done`.
        is_here: Whether this process works in place of a single one.

    Raises:
        GeoTLMError: If a part ended its worker twice and nothing stands for it, or if no worker
            can be started.
    """
    if not parts or (is_here and min(workers, len(parts)) <= 1):
        for part in parts:
            with _one_thread():
                done = work(part)
            yield done
        return
    suspects: list[Part] = []
    with _hiring() as hire:
        yield from _by_many(work, parts, hire(min(workers, len(parts))), hire, suspects)
    for part in suspects:
        with _hiring() as hire:
            future = hire(1)[0].submit(work, part)
            ended = isinstance(future.exception(), BrokenProcessPool)
            if ended and lost is None:
                raise GeoTLMError(
                    "A worker was ended from outside, most likely for want of memory; run this "
                    "again with fewer workers, what was finished is kept."
                )
            yield lost(part) if ended else future.result()


Hire = Callable[[int], list[ProcessPoolExecutor]]


def _by_many(
    work: Callable[[Part], Done],
    parts: Sequence[Part],
    free: list[ProcessPoolExecutor],
    hire: Hire,
    suspects: list[Part],
) -> Iterator[Done]:
    """Yield what workers return, each of one part at a time; add parts that ended theirs."""
    waiting = deque(parts)
    doing: dict[Future[Done], tuple[ProcessPoolExecutor, Part]] = {}

    def give() -> None:
        while waiting and free:
            worker = free.pop()
            try:
                doing[worker.submit(work, waiting[0])] = worker, waiting[0]
                waiting.popleft()
            except BrokenProcessPool:  # ended while it had nothing to do
                free.extend(hire(1))

    give()
    while doing:
        future = wait(doing, return_when=FIRST_COMPLETED).done.pop()
        worker, part = doing.pop(future)
        ended = isinstance(future.exception(), BrokenProcessPool)
        if ended:
            suspects.append(part)
        free += [worker] if not ended else hire(1) if waiting else []
        give()  # before others see what is done: a worker need not wait for them
        if not ended:
            yield future.result()


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
def _one_thread() -> Iterator[None]:
    """Work on one thread inside, as workers do: how many there are decides a sum's last bits."""
    import cv2
    import torch

    before = torch.get_num_threads(), cv2.getNumThreads()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before[0])
        cv2.setNumThreads(before[1])


def _prepare_worker() -> None:
    import cv2
    import torch

    threading.Thread(target=_end_with_parent, daemon=True).start()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    # A worker whose parent was killed would wait for its next part for ever.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
