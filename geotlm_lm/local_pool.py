"""Parts of a long run done by processes of this machine, one thread each; knows nothing of them."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.interrupts import children_killed_on_error, children_without_interrupts
from geotlm_lm.core.threads import one_thread_in_children

Part, Done = TypeVar("Part"), TypeVar("Done")


def each_done(work: Callable[[Part], Done], parts: Sequence[Part], workers: int) -> Iterator[Done]:
    """Yield what `work` returns of every part, in the order in which they are done.

    Args:
        work: A function of a module: processes import it.
        parts: What is to be done, each independent of the others.
        workers: Processes; 1 works in this one.

    Raises:
        GeoTLMError: If a worker was killed.
    """
    if workers <= 1 or len(parts) <= 1:
        for part in parts:
            with _one_thread():
                done = work(part)
            yield done
        return
    # Spawned, not forked: a forked process inherits torch's threads in an unusable state. And no
    # multiprocessing.Pool, which waits for ever for a worker that the system has killed.
    pool = ProcessPoolExecutor(
        min(workers, len(parts)),
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_prepare_worker,
    )
    try:
        with children_killed_on_error() as all_started:
            with children_without_interrupts(), one_thread_in_children():
                doing = [pool.submit(work, part) for part in parts]
            all_started()  # what the caller starts when it is told of a part is no worker
            for future in as_completed(doing):
                yield future.result()
    except BrokenProcessPool as error:
        raise GeoTLMError(
            "A worker was ended from outside, most likely for want of memory; run this again with "
            "fewer workers, what was finished is kept."
        ) from error
    finally:
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
