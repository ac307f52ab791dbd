"""Who does the parts of a long run: processes of this machine, or a Ray cluster's."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.core.process import usable_cores

Part, Done = TypeVar("Part"), TypeVar("Done")


@dataclass(frozen=True)
class Workers:
    """Processes of one thread each; what they do does not depend on which or how many they are.

    Args:
        count: How many, at most; None takes one for each core that this process, or the cluster,
            may use.
        cluster: Address of a Ray cluster, as `ray.init` takes it; "local" starts one on this
            machine. None works with processes of this machine, without Ray.
        is_here: Whether one alone may be this process, also where a part might end it.

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

    def each_done(
        self,
        work: Callable[[Part], Done],
        parts: Sequence[Part],
        *,
        seen: Sequence[Path] = (),
        lost: Callable[[Part], Done] | None = None,
    ) -> Iterator[Done]:
        """Yield what `work` returns of every part, in the order in which they are done.

        Args:
            work: A function of a module, or a `partial` of one: processes import it. Where a part
                of it was done already it does nothing: a cluster that loses a machine gives what
                this had to another one.
            parts: What is to be done, each independent of the others, and small: paths, not data.
            seen: Files and folders that are there, read or written beside: a cluster's machine that
                does not see one shares no folder with this one, and gets no part.
            lost: Returns what stands for a part that ended two processes of this machine, the
                second with no other at work; None: such a part ends the run. A cluster starts
                what it lost again by its own rules.

        Raises:
            GeoTLMError: If a part ended its worker and nothing stands for it, if no worker can be
                started, or if the cluster cannot be used.
        """
        # Imported only now: every command line knows of workers, few need any.
        if self.cluster is None:
            from geotlm_lm.local_pool import each_done

            is_here = self.is_here or lost is None
            return each_done(work, parts, self.count or usable_cores(), lost, is_here=is_here)
        from geotlm_lm.cluster import each_done_on

        return each_done_on(self.cluster, work, parts, self.count, seen)


ALONE = Workers(1, is_here=True)
"""This process does all of it."""

LOST = (
    "two processes that worked on it were ended, the second with no other beside it, expected a "
    "recording that can be decoded in the memory there is; write its file anew, or leave it out."
)
"""What stands in place of a result that no process lives to give."""
