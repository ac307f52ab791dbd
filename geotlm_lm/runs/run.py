"""The protocol of long runs: a function mapped over parts, each result kept in a file of its own.

A folder of settings says what a started run is of. Each result is written whole by whoever does the
part and then renamed, so that a stopped run is continued by the files that are there, and a run
begun by processes of this machine can be finished on a cluster. Ctrl-C and SIGTERM end workers at
once, but for one that is writing.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, TypeVar

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.core.files import only_writer, replacing, write_text_atomically
from geotlm_lm.core.process import Progress, silent, uninterrupted_step, usable_cores

Part, Result = TypeVar("Part"), TypeVar("Result")

LOST = (
    "two processes that worked on it were ended, the second with no other beside it, expected a "
    "recording that can be decoded in the memory there is; write its file anew, or leave it out."
)
"""Stands in place of the result of a part that ends its process."""

SETTINGS = "settings.json"


@dataclass(frozen=True)
class Workers:
    """Processes of one thread each; results do not depend on which or how many they are.

    Args:
        count: At most; None takes one for each core that this process, or the cluster, may use.
        cluster: Address of a Ray cluster, as `ray.init` takes it; "local" starts one on this
            machine. None works with processes of this machine, without Ray.
        is_here: Whether a single worker may be this process, even where a part might end it.

    Raises:
        MissingDependency: If a cluster is given and Ray is not installed.
    """

    count: int | None = None
    cluster: str | None = None
    is_here: bool = field(default=False, compare=False)

    def __post_init__(self) -> None:
        if self.cluster is not None and find_spec("ray") is None:
            raise MissingDependency(
                "--cluster needs Ray, which is not installed; run `pip install 'geotlm-lm[ray]'`."
            )

    def map(
        self,
        work: Callable[[Part], Result],
        parts: Sequence[Part],
        *,
        seen: Sequence[Path] = (),
        lost: Callable[[Part], Result] | None = None,
    ) -> Iterator[tuple[Part, Result]]:
        """Yield each part with what `work` returns of it, in the order in which they are done.

        Args:
            work: A function of a module, or a `partial` of one: processes import it.
            parts: Independent of each other, and small: paths, not data.
            seen: Files and folders that are there: a cluster's machine that does not see one
                shares no folder with this one, and gets no part.
            lost: Returns what stands for a part that ended two processes of this machine, the
                second with no other at work; None: such a part ends the run. A cluster starts
                what it lost again by its own rules.

        Raises:
            GeoTLMError: If a part ended its worker and nothing stands for it, if no worker can be
                started, or if the cluster cannot be used.
        """
        # Imported only now: every command line knows of workers, few need any.
        if self.cluster is None:
            from geotlm_lm.runs.processes import map_by_processes

            is_here = self.is_here or lost is None
            count = self.count or usable_cores()
            return map_by_processes(work, parts, count, lost, is_here=is_here)
        from geotlm_lm.runs.cluster import map_by_cluster

        return map_by_cluster(self.cluster, work, parts, self.count, seen)


ALONE = Workers(1, is_here=True)
"""This process does all of it."""


@contextmanager
def run_folder(
    folder: Path, settings: dict[str, Any], of: str, *, is_replaced: bool = False
) -> Iterator[Path]:
    """Begin the run of these settings in a folder, or go on with the one that was stopped there.

    Args:
        folder: Keeps the results; nobody else writes there while the block runs.
        settings: Plain JSON values that decide the results; another run's are not continued.
        of: What they are, for the sentence that refuses another run.
        is_replaced: Whether another run is deleted rather than refused.

    Yields:
        The file with the settings, which whoever does a part must see.

    Raises:
        UsageError: If something else than this run is there, or another process is at it.
        Unwritten: If the folder cannot be written.
    """
    with only_writer(folder) as is_alone:
        if not is_alone:
            raise UsageError(
                f"{folder}: another run is writing it, expected one at a time; wait for it, or "
                f"give another --out."
            )
        stamp = folder / SETTINGS
        stored = load_json(stamp)
        is_other = stored != settings and (stored is not None or _holds_something(folder))
        if folder.is_symlink() or (is_other and not (is_replaced and stored is not None)):
            raise UsageError(
                f"{folder}: belongs to a run of other {of}, or of another model or version, "
                f"expected this one's; delete it to begin anew, or give another --out."
            )
        if is_other:
            shutil.rmtree(folder)
        if stored != settings:
            write_text_atomically(stamp, json.dumps(settings) + "\n")
        yield stamp


def _holds_something(folder: Path) -> bool:
    if not folder.is_dir():
        return folder.exists()
    return any(not path.name.startswith(".") for path in folder.iterdir())


def do_parts(
    what: str,
    work: Callable[[Part], Result],
    jobs: Sequence[tuple[Part, Path]],
    save: Callable[[IO[bytes], Result], object],
    *,
    is_kept: Callable[[Part, Path], bool] | None = None,
    size: Callable[[Part], int] = lambda part: 1,
    workers: Workers = ALONE,
    seen: Sequence[Path] = (),
    lost: Callable[[Part], Result] | None = None,
    progress: Progress = silent,
) -> int:
    """Do the parts whose results are not kept yet; return how many of them were.

    Args:
        what: Name of the stage, for `progress`.
        work: As of `Workers.map`.
        jobs: Each part with the file that keeps its result.
        save: Writes a result; a function of a module.
        is_kept: Whether a file holds a part's whole result, a function of a module; by default
            whether it is there.
        size: What a part counts for in `progress`.
        workers: Who works; files do not depend on it.
        seen: As of `Workers.map`.
        lost: As of `Workers.map`.
        progress: Called after every part.

    Raises:
        GeoTLMError: As of `Workers.map`.
        Unwritten: If a result cannot be written.
    """
    is_kept = is_kept or _is_there
    missing = [job for job in jobs if not is_kept(*job)]
    total = sum(size(part) for part, _ in jobs)
    done = total - sum(size(part) for part, _ in missing)
    keep_lost = None if lost is None else partial(_keep, lost, save, None)
    keep = partial(_keep, work, save, is_kept)
    # Closed at once: an error of `progress` must not leave workers to the end of its traceback.
    with closing(workers.map(keep, missing, seen=seen, lost=keep_lost)) as results:
        for (part, _), _ in results:
            done += size(part)
            progress(what, done, total)
    return len(jobs) - len(missing)


def _is_there(part: object, path: Path) -> bool:
    return path.exists()


def _keep(
    work: Callable[[Part], Result],
    save: Callable[[IO[bytes], Result], object],
    is_kept: Callable[[Part, Path], bool] | None,
    job: tuple[Part, Path],
) -> None:
    # A cluster that loses a machine gives all that this one had to another.
    if is_kept is not None and is_kept(*job):
        return
    part, path = job
    result = work(part)
    with uninterrupted_step(), replacing(path) as stream:
        save(stream, result)


def save_json(stream: IO[bytes], value: Any) -> None:
    """Write plain JSON values, for `do_parts`."""
    stream.write(json.dumps(value).encode())


def load_json(path: Path) -> Any:
    """Return what `save_json` wrote; None where that is missing or damaged."""
    try:
        return json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None


def holds_json(part: object, path: Path) -> bool:
    """Tell whether a file holds what `save_json` wrote, for `do_parts`."""
    return load_json(path) is not None
