"""Say a question in other words of the same meaning, from data_templates/query/thesaurus.toml.

A family's templates hold the words that came to their writer; the thesaurus puts others in their
place, so that a reader learns what stays when the words change.
"""

from __future__ import annotations

import random
import re
import tomllib
from collections.abc import Iterator, Sequence
from functools import lru_cache

from geotlm_lm.core.files import training_templates
from geotlm_lm.query.quantities import find
from geotlm_lm.training.grammar import Pair

_WORD = re.compile(r"[^\W\d_](?:[\w'-]*\w)?")
_ARTICLE = re.compile(r"\b([Aa])n? $")
SHARE = 0.35
"""Of the words that have others, those that are exchanged."""


class Thesaurus:
    """Words and phrases that may stand for each other.

    Args:
        groups: Of each group its rows, of each row its forms; equal columns replace each other,
            "" where a row lacks a form.
    """

    def __init__(self, groups: Sequence[Sequence[Sequence[str]]]) -> None:
        self._others: dict[tuple[str, ...], list[str]] = {}
        for rows in groups:
            for column in zip(*rows, strict=True):
                forms = sorted({form for form in column if form})
                for form in forms:
                    others = self._others.setdefault(tuple(form.split()), [])
                    others += [each for each in forms if each != form and each not in others]
        self._longest = max(map(len, self._others), default=0)

    def others(self, phrase: str) -> list[str]:
        """Return what may stand for a word or a phrase."""
        return self._others.get(tuple(phrase.lower().split(" ")), [])

    def varied(self, rng: random.Random, pair: Pair, share: float = SHARE) -> Pair:
        """Return a pair with some of its words exchanged, its numbers what they were."""
        text, at = "", 0
        for start, end, others in self._exchangeable(pair.text):
            if rng.random() < share:
                new = rng.choice(others)
                before = _ARTICLE.sub(
                    r"\1n " if new[0] in "aeiou" else r"\1 ", text + pair.text[at:start]
                )
                if pair.text[start].isupper():
                    new = new[0].upper() + new[1:]
                text, at = before + new, end
        text += pair.text[at:]
        numbers = [[quantity.quantity for quantity in find(each)] for each in (text, pair.text)]
        return pair if numbers[0] != numbers[1] else Pair(text, pair.query, pair.families)

    def _exchangeable(self, text: str) -> Iterator[tuple[int, int, list[str]]]:
        """Yield where a text's longest known phrases are, and what may stand for each."""
        taken = [(each.start, each.end) for each in find(text)]
        words = [
            match
            for match in _WORD.finditer(text)
            if not any(match.start() < end and start < match.end() for start, end in taken)
        ]
        place = 0
        while place < len(words):
            for count in range(min(self._longest, len(words) - place), 0, -1):
                start, end = words[place].start(), words[place + count - 1].end()
                if others := self.others(text[start:end]):
                    yield start, end, others
                    place += count - 1
                    break
            place += 1


@lru_cache(maxsize=1)
def thesaurus() -> Thesaurus:
    """Return the thesaurus, read once."""
    path = training_templates() / "query" / "thesaurus.toml"
    groups = tomllib.loads(path.read_text(encoding="utf-8"))["group"]
    return Thesaurus([group["rows"] for group in groups])
