"""What a question was taken to mean, as its reader wrote it."""

from __future__ import annotations

from dataclasses import dataclass

from geotlm_lm.query.program import Program, filled, read
from geotlm_lm.query.quantities import Quantity


@dataclass(frozen=True)
class Reading:
    """What a question was taken to mean."""

    line: str  # the program's words, numbers and copied words as slots
    quantities: tuple[Quantity, ...]  # numbers of the question, for the slots
    texts: tuple[str, ...]  # its words that may be copied
    probability: float  # that this is what was meant, calibrated
    chance: float  # that the model writes it, not calibrated

    @property
    def slotted(self) -> Program:
        """The program with slots."""
        return read(self.line)

    @property
    def program(self) -> Program:
        """The program with the question's numbers and words."""
        return filled(read(self.line), self.quantities, self.texts)
