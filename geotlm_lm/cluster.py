"""Parts of a long run done by a Ray cluster, one thread each; knows nothing of them.

A Ray Data pipeline carries the parts, which are paths and numbers, to a pool of actors and carries
back what the work returns. Ray's own checkpoints are left alone: they know of rows that Ray wrote,
where our work writes a file for each part; so a run that was begun on one machine can be finished
on a cluster, and the other way round.
"""

from __future__ import annotations

import logging
import os
import pickle
import signal
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from geotlm_lm import __version__
from geotlm_lm.core.errors import GeoTLMError, UsageError, first_line
from geotlm_lm.core.process import THREAD_VARIABLES, usable_cores

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Part, Done = TypeVar("Part"), TypeVar("Done")

LOCAL = "local"

CPUS_PER_ACTOR = 0.5
"""What Ray counts for an actor: at 1, actors on all cores leave none to the rest of a pipeline."""

MOST_BLOCKS = 10_000
"""Blocks of parts that Ray keeps account of; of more parts, several travel together."""

LOCAL_STORE_BYTES = 128 * 2**20
"""Memory that a cluster started here shares: only paths travel through it."""


def each_done_on(
    address: str,
    work: Callable[[Part], Done],
    parts: Sequence[Part],
    workers: int | None,
    seen: Sequence[Path] = (),
) -> Iterator[Done]:
    """Yield what `work` returns of every part, in the order in which they are done.

    Args:
        address: Of the cluster; "local" starts one on this machine for the time of the run.
        work: As of `Workers.each_done`.
        parts: What is to be done; machines that do it see the same files by the same names.
        workers: Actors, at most; None takes one for each of the cluster's CPUs.
        seen: As of `Workers.each_done`.

    Raises:
        UsageError: If the cluster cannot be reached, or its machines do not see this folder or
            what is in `seen`, or have another version installed.
    """
    if not parts:
        return
    with _connected(address, workers):
        import ray

        count = workers or max(1, int(ray.cluster_resources().get("CPU", 1)))
        rows = iter(_pipeline(work, parts, min(count, len(parts)), seen).iter_rows())
        try:
            for row in rows:
                done, error = pickle.loads(row["done"])
                if error is not None:
                    raise error
                yield done
        finally:
            rows.close()  # ends the actors at once where the caller stops


def _pipeline(
    work: Callable[[Any], Any], parts: Sequence[Any], actors: int, seen: Sequence[Path]
) -> Any:
    """Return the Ray data set that holds what is done of each part, once it is asked for."""
    import ray

    rows = [{"part": pickle.dumps(part)} for part in parts]
    blocks = min(len(parts), MOST_BLOCKS)
    return ray.data.from_items(rows, override_num_blocks=blocks).map_batches(
        _Worker,
        fn_constructor_args=(work, os.getcwd(), __version__, seen),
        batch_size=1,
        batch_format="numpy",
        num_cpus=CPUS_PER_ACTOR,
        # A pool that grows: where a machine is lost, or joins, work goes on with those there are.
        compute=ray.data.ActorPoolStrategy(min_size=1, max_size=actors, initial_size=actors),
        runtime_env={"env_vars": dict.fromkeys(THREAD_VARIABLES, "1")},
    )


class _Worker:
    """An actor of the pool; errors are returned, so that they arrive as they were raised."""

    def __init__(
        self, work: Callable[[Any], Any], folder: str, version: str, seen: Sequence[Path]
    ) -> None:
        import cv2
        import torch

        self.work, self.folder, self.version, self.seen = work, folder, version, seen
        torch.set_num_threads(1)
        cv2.setNumThreads(1)

    def __call__(self, batch: dict[str, NDArray[Any]]) -> dict[str, NDArray[np.object_]]:
        import numpy as np

        done = np.empty(len(batch["part"]), object)
        for number, part in enumerate(batch["part"]):
            done[number] = self._done(part)
        return {"done": done}

    def _done(self, part: bytes) -> bytes:
        try:
            self._stand_where_the_command_does()
            return pickle.dumps((self.work(pickle.loads(part)), None))
        except Exception as error:
            error.add_note(traceback.format_exc())
            return pickle.dumps((None, error))

    def _stand_where_the_command_does(self) -> None:
        """Let relative paths mean here what they mean where the command was typed."""
        if __version__ != self.version:
            raise UsageError(
                f"{_machine()}: has geotlm-lm {__version__}, expected {self.version} as where the "
                f"command runs; install that."
            )
        try:
            os.chdir(self.folder)
        except OSError as error:
            raise UsageError(
                f"{_machine()}: has no folder {self.folder}, expected what the command sees; run "
                f"it in a folder that all machines of the cluster share."
            ) from error
        # A machine of its own files would write where nobody looks, or miss what it is to read.
        missing = next((path for path in self.seen if not path.exists()), None)
        if missing is not None:
            raise UsageError(
                f"{_machine()}: has no {missing.absolute()}, expected what the command sees; keep "
                f"what is read and written in a folder that all machines of the cluster share."
            )


def _machine() -> str:
    import socket

    return socket.gethostname()


@contextmanager
def _connected(address: str, workers: int | None) -> Iterator[None]:
    """Connect to a cluster, or start one; a connection that the caller has is used and kept."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # a cluster started here reports nothing
    os.environ.setdefault("RAY_BACKEND_LOG_LEVEL", "fatal")  # else warnings of Ray about Ray Data
    import ray

    is_own = not ray.is_initialized()
    if is_own:
        options: dict[str, Any] = {"address": address}
        if address == LOCAL:
            # Beside other work Ray's processes would wait: it starts them at niceness 15.
            os.environ.setdefault("RAY_worker_niceness", "0")
            options |= {"num_cpus": max(usable_cores(), workers or 1), "include_dashboard": False}
            options |= {"object_store_memory": LOCAL_STORE_BYTES}
        try:
            with _own_end_kept():
                ray.init(logging_level=logging.ERROR, log_to_driver=False, **options)
        except (OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
            raise UsageError(
                f"--cluster {address}: cannot be used ({first_line(error)}), expected local, auto, "
                f"or the address of a Ray cluster's head; give one, and set RAY_AUTH_MODE=token "
                f"where `ray start` began it."
            ) from error
    try:
        _keep_quiet()
        yield
    except ray.exceptions.RayError as error:
        raise GeoTLMError(
            f"The cluster ended the work ({first_line(error)}); run this again, what was finished "
            f"is kept."
        ) from error
    finally:
        if is_own:
            ray.shutdown()


@contextmanager
def _own_end_kept() -> Iterator[None]:
    """Keep what a request to end (SIGTERM) does here: Ray would have the process exit at once."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, before or signal.SIG_DFL)  # None: set outside Python


def _keep_quiet() -> None:
    """Let Ray Data draw no bars and tell no plans: the command tells how far it is."""
    import ray.data

    context = ray.data.DataContext.get_current()
    context.enable_progress_bars = False
    context.print_on_execution_start = False
    logging.getLogger("ray.data").setLevel(logging.ERROR)
