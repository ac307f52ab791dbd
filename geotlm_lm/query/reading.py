"""What a question was taken to mean, as its reader wrote it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.text import read
from geotlm_lm.query.types import Query, filled


@dataclass(frozen=True)
class Reading:
    """What a question was taken to mean.

    Args:
        line: The query's words, numbers as slots.
        quantities: Numbers of the question, for the slots.
        probability: That this is what was meant, calibrated.
        chance: That the model writes it, not calibrated.
    """

    line: str
    quantities: tuple[Quantity, ...]
    probability: float
    chance: float

    @property
    def query(self) -> Query:
        """The query with its numbers."""
        return filled(read(self.line, len(self.quantities)), self.quantities)

    @property
    def clauses(self) -> list[str]:
        """The query's facts and parts, each in words."""
        return self.line.split(" ; ")

    @property
    def states_only(self) -> bool:
        """Whether it states facts and asks nothing."""
        return all(one.startswith("fact ") for one in self.clauses)

    def at(self, places: Sequence[int]) -> Reading:
        """Return it with each number's place in a longer text, from 1, for that in its own."""
        words = self.line.split()
        moved = [f"#{places[int(one[1:]) - 1]}" if one[0] == "#" else one for one in words]
        return replace(self, line=" ".join(moved))
