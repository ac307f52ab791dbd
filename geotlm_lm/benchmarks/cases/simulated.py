"""Simulated clips of everyday objects that no weight was trained on, and the tasks they pose."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.numbers import seed_for

if TYPE_CHECKING:
    from geotlm_lm.simulation.simulate import SimulatedClip

TASKS: dict[str, tuple[Motion, ...]] = {
    "rotation": ROTATIONS,
    "sliding": SLIDES,
    "all": tuple(Motion),
}
"""The simulated tasks: the paper's two, and all ten motions together."""

MOST_TRIES = 6
"""Scenes simulated per clip asked for, at most: a bound on a search, not an expected number."""


@dataclass
class SimulatedCases:
    """Readable simulated clips of objects that no training ever uses.

    Args:
        task: One of `TASKS`.
        count: How many clips to give.
        seed: Root of the scenes.
        unreadable: How many clips came up whose images do not tell the motion; filled while
            iterating.
    """

    task: str
    count: int
    seed: int
    unreadable: int = field(default=0)

    @property
    def among(self) -> tuple[Motion, ...]:
        """The motions in question."""
        return TASKS[self.task]

    def __iter__(self) -> Iterator[Case]:
        for made in self.made():
            name = made.object_name
            yield Case(made.clip, made.label.motion, name, name)

    def made(self) -> Iterator[SimulatedClip]:
        """Yield the same clips with the whole truth about them."""
        from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
        from geotlm_lm.simulation.simulate import simulate_series

        self.unreadable = given = 0
        series = simulate_series(
            seed_for(self.seed, "evaluation", self.task),
            MOST_TRIES * self.count,
            objects=EVERYDAY_OBJECTS,
            motions=self.among,
        )
        for made in series:
            if not made.label.is_readable:
                self.unreadable += 1
                continue
            yield made
            given += 1
            if given == self.count:
                return
