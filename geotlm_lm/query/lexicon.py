"""Mend slips of the fingers: two letters swapped, or one left out, of a word that is often read.

A letter changed or added is left to the reader: that turns too many rare words into frequent ones
("ratio" into "radio").
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from string import ascii_lowercase

LEAST, FREQUENT = 10, 40
"""How often a known word stands in the texts a lexicon is made of, and one that is mended to."""

SLIPS = 100
"""How much rarer than the word it is a slip of a slip is: texts made to be read hold some."""

SHORTEST, SHORTEST_WHOLE = 3, 6
"""Letters of a word of which two are swapped, and of one that has lost one."""

_WORD = re.compile(r"[^\W\d_]+")


@dataclass(frozen=True)
class Lexicon:
    """Words that a reader knows.

    Args:
        words: In lower case, the most frequent first.
        frequent: How many of them are mended to.
    """

    words: tuple[str, ...] = ()
    frequent: int = 0

    @classmethod
    def of(cls, texts: Iterable[str]) -> Lexicon:
        """Return the frequent words of some texts."""
        counts = Counter(word for text in texts for word in _WORD.findall(text.lower()))
        known = [
            (word, count)
            for word, count in counts.most_common()
            if count >= LEAST
            and not any(counts[meant] >= SLIPS * count for meant in _slipped_from(word))
        ]
        frequent = sum(count >= FREQUENT for _, count in known)
        return cls(tuple(word for word, _ in known), frequent)

    def mended(self, text: str) -> str:
        """Return a text with its misspelt words as they were meant; others stay as they are."""
        return _WORD.sub(lambda match: self._meant(match[0]), text) if self.words else text

    @cached_property
    def _rank(self) -> dict[str, int]:
        return {word: place for place, word in enumerate(self.words)}

    @cached_property
    def _longest(self) -> int:
        return max(map(len, self.words), default=0)

    def _meant(self, written: str) -> str:
        word = written.lower()
        if word in self._rank or not SHORTEST <= len(word) <= self._longest:
            return written
        ranks = (self._rank.get(meant, self.frequent) for meant in _slipped_from(word))
        place = min(ranks, default=0)
        return self.words[place] if place < self.frequent else written


def _slipped_from(word: str) -> Iterator[str]:
    """Yield what a word may be a slip of."""
    for at in range(len(word) - 1):
        yield word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    if len(word) + 1 >= SHORTEST_WHOLE:
        for at in range(1, len(word)):
            yield from (word[:at] + letter + word[at:] for letter in ascii_lowercase)
