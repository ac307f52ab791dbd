"""Parts of a long run done by a Ray cluster, one thread each; knows nothing of them.

A Ray Data pipeline carries the parts, which are paths and numbers, to a pool of actors and carries
back what the work returns. Ray's own checkpoints are not used: they know of rows that Ray wrote,
where our work writes a file for each part.
"""

from __future__ import annotations

import logging
import os
import pickle
import signal
import socket
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

Part, Result = TypeVar("Part"), TypeVar("Result")

LOCAL = "local"

CPUS_PER_ACTOR = 0.5
"""What Ray counts for an actor: at 1, actors on all cores leave none to the rest of a pipeline."""

MOST_BLOCKS = 10_000
"""Blocks of parts that Ray keeps account of; of more parts, several travel together."""

LOCAL_STORE_BYTES = 128 * 2**20
"""Memory that a cluster started here shares: only paths travel through it."""


def map_by_cluster(
    address: str,
    work: Callable[[Part], Result],
    parts: Sequence[Part],
    workers: int | None,
    seen: Sequence[Path] = (),
) -> Iterator[tuple[Part, Result]]:
    """Yield each part with what `work` returns of it; arguments as of `Workers.map`.

    Raises:
        UsageError: If the cluster cannot be reached, or its machines do not see this folder or
            what is in `seen`, or have another version installed.
    """
    if not parts:
        return
    with _connected(address, workers):
        import ray

        count = min(workers or max(1, int(ray.cluster_resources().get("CPU", 1))), len(parts))
        rows = [{"part": pickle.dumps(part)} for part in parts]
        pipeline = ray.data.from_items(
            rows, override_num_blocks=min(len(parts), MOST_BLOCKS)
        ).map_batches(
            _Worker,
            fn_constructor_args=(work, os.getcwd(), __version__, seen),
            batch_size=1,
            batch_format="numpy",
            num_cpus=CPUS_PER_ACTOR,
            # A pool that grows: where a machine is lost, or joins, work goes on with what is there.
            compute=ray.data.ActorPoolStrategy(min_size=1, max_size=count, initial_size=count),
            runtime_env={"env_vars": dict.fromkeys(THREAD_VARIABLES, "1")},
        )
        done = iter(pipeline.iter_rows())
        try:
            for row in done:
                part, result, error = pickle.loads(row["done"])
                if error is not None:
                    raise error
                yield part, result
        finally:
            done.close()  # ends the actors at once where the caller stops


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
            done[number] = self._done(pickle.loads(part))
        return {"done": done}

    def _done(self, part: Any) -> bytes:
        try:
            self._stand_where_the_command_does()
            return pickle.dumps((part, self.work(part), None))
        except Exception as error:
            error.add_note(traceback.format_exc())
            return pickle.dumps((part, None, error))

    def _stand_where_the_command_does(self) -> None:
        """Let relative paths mean here what they mean where the command was typed."""
        here = socket.gethostname()
        if __version__ != self.version:
            raise UsageError(
                f"{here}: has geotlm-lm {__version__}, expected {self.version} as where the "
                f"command runs; install that."
            )
        try:
            os.chdir(self.folder)
        except OSError as error:
            raise UsageError(
                f"{here}: has no folder {self.folder}, expected what the command sees; run "
                f"it in a folder that all machines of the cluster share."
            ) from error
        # A machine of its own files would write where nobody looks, or miss what it is to read.
        missing = next((path for path in self.seen if not path.exists()), None)
        if missing is not None:
            raise UsageError(
                f"{here}: has no {missing.absolute()}, expected what the command sees; keep "
                f"what is read and written in a folder that all machines of the cluster share."
            )


@contextmanager
def _connected(address: str, workers: int | None) -> Iterator[None]:
    """Connect to a cluster, or start one; a connection that the caller has is used and kept."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # a cluster started here reports nothing
    os.environ.setdefault("RAY_BACKEND_LOG_LEVEL", "fatal")  # else warnings of Ray about Ray Data
    import ray
    import ray.data

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
        # Ray Data draws no bars and tells no plans: the command tells how far it is.
        context = ray.data.DataContext.get_current()
        context.enable_progress_bars = context.print_on_execution_start = False
        logging.getLogger("ray.data").setLevel(logging.ERROR)
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
