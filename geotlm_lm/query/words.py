"""Read a line of words from the left, and know at each place what could have stood there."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.core.errors import UsageError
from geotlm_lm.query.types import Number, Quantity, Slot

END = "<end>"
"""Stands among the next words where a query may end."""


class Malformed(UsageError):
    """A text is no query: the word found and those that could stand there."""

    def __init__(self, words: Sequence[str], at: int, expected: Sequence[str]) -> None:
        given = repr(words[at]) if at < len(words) else "nothing more"
        super().__init__(
            f"A query had {given} after {' '.join(words[:at])!r}, expected one of "
            f"{', '.join(sorted(expected))}; write one of these there."
        )
        self.at, self.expected = at, frozenset(expected)


class Words:
    """Words read from the left; remembers what could have stood at the present place."""

    def __init__(self, words: Sequence[str], slots: int) -> None:
        self.words, self.at, self.slots = list(words), 0, slots
        self.open: list[tuple[str, list]] = []  # primitives that lack an argument yet
        self.expected: set[str] = set()

    @property
    def next(self) -> str:
        """The next word; "" at the end."""
        return self.words[self.at] if self.at < len(self.words) else ""

    def has(self, *names: str) -> bool:
        """Tell whether one of some words is next."""
        self.expected.update(names)
        return self.at < len(self.words) and self.words[self.at] in names

    def take(self, *names: str) -> str:
        """Return the next word, which must be one of some."""
        if not self.has(*names):
            raise Malformed(self.words, self.at, sorted(self.expected))
        self.at, self.expected = self.at + 1, set()
        return self.words[self.at - 1]

    def optional(self, *names: str) -> str | None:
        """Return the next word if it is one of some."""
        return self.take(*names) if self.has(*names) else None

    def number(self) -> Number:
        """Return a slot, or a quantity written out as "12.5:deg"."""
        if self.at < len(self.words) and ":" in self.words[self.at]:
            value, _, unit = self.words[self.at].partition(":")
            self.at, self.expected = self.at + 1, set()
            return Quantity(float(value), unit)
        return Slot(int(self.take(*(f"#{k + 1}" for k in range(self.slots)))[1:]))

    def close(self) -> None:
        """Require that no word is left."""
        if self.at < len(self.words):
            raise Malformed(self.words, self.at, sorted({*self.expected, END}))


def number_word(value: Number) -> str:
    """Return a number as `Words.number` reads it: "#2", or "12.5:deg"."""
    return f"#{value.index}" if isinstance(value, Slot) else f"{value.value!r}:{value.unit}"
