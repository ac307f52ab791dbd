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

LEAST = 10
"""How often a word stands in the texts a lexicon is made of, at the least."""

SHORTEST, SHORTEST_WHOLE = 3, 6
"""Letters of a word of which two are swapped, and of one that has lost one."""

_WORD = re.compile(r"[^\W\d_]+")


@dataclass(frozen=True)
class Lexicon:
    """Words that a reader knows.

    Args:
        words: In lower case, the most frequent first.
    """

    words: tuple[str, ...] = ()

    @classmethod
    def of(cls, texts: Iterable[str]) -> Lexicon:
        """Return the frequent words of some texts."""
        counts = Counter(word for text in texts for word in _WORD.findall(text.lower()))
        return cls(tuple(word for word, count in counts.most_common() if count >= LEAST))

    def mended(self, text: str) -> str:
        """Return a text with its misspelt words as they were meant; others stay as they are."""
        return _WORD.sub(lambda match: self._meant(match[0]), text) if self.words else text

    @cached_property
    def _rank(self) -> dict[str, int]:
        return {word: place for place, word in enumerate(self.words)}

    def _meant(self, written: str) -> str:
        word = written.lower()
        if word in self._rank or len(word) < SHORTEST:
            return written
        found = [one for one in _slipped_from(word) if one in self._rank]
        return min(found, key=self._rank.__getitem__) if found else written


def _slipped_from(word: str) -> Iterator[str]:
    """Yield what a word may be a slip of."""
    for at in range(len(word) - 1):
        yield word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    if len(word) + 1 >= SHORTEST_WHOLE:
        for at in range(1, len(word)):
            yield from (word[:at] + letter + word[at:] for letter in ascii_lowercase)
