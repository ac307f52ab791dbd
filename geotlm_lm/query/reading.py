"""What a question was taken to mean, as its reader wrote it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.text import read, write
from geotlm_lm.query.types import Query, Slot, filled


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
    def slotted(self) -> Query:
        """The query with slots for its numbers."""
        return read(self.line)

    @property
    def query(self) -> Query:
        """The query with its numbers."""
        return filled(read(self.line, len(self.quantities)), self.quantities)

    def means(self, other: Reading) -> bool:
        """Tell whether another reading means the same; the order of facts is free."""
        one, another = self.slotted, other.slotted
        is_so = (one.parts, one.form) == (another.parts, another.form)
        return is_so and set(one.facts) == set(another.facts)

    def at(self, places: Sequence[int]) -> Reading:
        """Return it with each number's place in a longer text, from 1, for that in its own."""
        return replace(self, line=write(filled(self.slotted, tuple(map(Slot, places)))))
