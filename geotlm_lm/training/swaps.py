"""Exchange words of a labelled question together with what they mean, from swaps.toml.

A question that was labelled once teaches its syntax with other contents too: "when did the first
slide to the left end" with the last one, to the right, and how it began. A group is exchanged only
where text and program hold the same of its meanings, so that a word that means something else there
("right?") is left as it is.
"""

from __future__ import annotations

import random
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain

from geotlm_lm.core.files import training_templates
from geotlm_lm.query.copied import copied
from geotlm_lm.query.lines import Malformed, normal, read, write
from geotlm_lm.query.program import UNITS, dimension_of, is_void
from geotlm_lm.query.quantities import find, quantities
from geotlm_lm.training.grammar import Pair

SHARE = 0.6
"""Of the groups that a question holds, those that are exchanged."""


@dataclass(frozen=True)
class Group:
    """Meanings that may take each other's place.

    Args:
        program: Of each meaning its words in programs; equal columns replace each other.
        text: Of each meaning its words in texts, likewise.
        without: Words of programs beside which the group stays as it is.
        units: Dimensions of stated numbers and units beside which it does.
    """

    program: Sequence[Sequence[str]]
    text: Sequence[Sequence[str]]
    without: frozenset[str]
    units: frozenset[str]

    def meanings_of(self, words: Sequence[str]) -> set[int]:
        """Return the places of the meanings that a program's words hold."""
        return {place for place, own in enumerate(self.program) if set(own) & set(words)}

    @property
    def pattern(self) -> re.Pattern[str]:
        """What finds the group's words in a text, the longest first."""
        words = sorted(set(chain.from_iterable(self.text)), key=len, reverse=True)
        return re.compile(rf"(?<![\w-])(?:{'|'.join(map(re.escape, words))})(?![\w-])", re.I)

    def place_of(self, word: str) -> tuple[int, int]:
        """Return the first meaning and column of a word of a text, whatever its case."""
        small = word.lower()
        place = next(place for place, words in enumerate(self.text) if small in words)
        return place, self.text[place].index(small)


class Swaps:
    """What may be exchanged in questions and programs.

    Args:
        groups: Of meanings.
    """

    def __init__(self, groups: Sequence[Group]) -> None:
        self._groups = [(group, group.pattern) for group in groups]

    def exchanged(self, rng: random.Random, pair: Pair, share: float = SHARE) -> Pair:
        """Return a pair with some of its meanings exchanged; its numbers and copied words stay."""
        new = pair
        for group, pattern in self._groups:
            if rng.random() < share and (present := _present(group, pattern, new)):
                new = _with(group, pattern, new, _drawn(rng, present, len(group.text)))
        return new if new is pair or _is_sound(pair, new) else pair


def _present(group: Group, pattern: re.Pattern[str], pair: Pair) -> set[int]:
    """Return the meanings of a group that text and program both hold; none where they differ."""
    words = pair.query.split()
    meant = group.meanings_of(words)
    if not meant or group.without & set(words):
        return set()
    stated = find(pair.text)
    units = [each.quantity.unit for each in stated] + [
        word for word in words if any(word in units for units in UNITS.values())
    ]
    if group.units & set(map(dimension_of, units)):
        return set()
    spoken_of = {group.place_of(match[0])[0] for match in _free(pattern, pair.text)}
    return meant if spoken_of == meant else set()


def _free(pattern: re.Pattern[str], text: str) -> list[re.Match[str]]:
    """Return the group's words in a text that are none of a number or of what is copied."""
    taken = (*find(text), *copied(text))
    return [
        match
        for match in pattern.finditer(text)
        if not any(match.start() < each.end and each.start < match.end() for each in taken)
    ]


def _drawn(rng: random.Random, present: set[int], count: int) -> dict[int, int]:
    """Return what takes the place of each meaning, all of them different."""
    return dict(zip(sorted(present), rng.sample(range(count), len(present)), strict=True))


def _with(group: Group, pattern: re.Pattern[str], pair: Pair, new: Mapping[int, int]) -> Pair:
    text, at = "", 0
    for match in _free(pattern, pair.text):
        place, column = group.place_of(match[0])
        word = group.text[new[place]][column]
        if match[0][0].isupper():
            word = word.upper() if match[0].isupper() else word[0].upper() + word[1:]
        text, at = text + pair.text[at : match.start()] + word, match.end()
    words = {
        own: group.program[new[place]][column]
        for place in new
        for column, own in enumerate(group.program[place])
    }
    query = " ".join(words.get(word, word) for word in pair.query.split())
    return Pair(text + pair.text[at:], query, pair.families)


def _is_sound(before: Pair, after: Pair) -> bool:
    """Tell whether numbers and copied words are what they were, and the program is one."""
    numbers = [quantities(pair.text) for pair in (before, after)]
    words = [[each.text for each in copied(pair.text)] for pair in (before, after)]
    if numbers[0] != numbers[1] or words[0] != words[1]:
        return False
    try:
        program = read(after.query)
    except Malformed:
        return False
    return not is_void(program) and write(normal(program)) == after.query


def _groups(rows: Sequence[Mapping[str, object]]) -> Iterator[Group]:
    for row in rows:
        program, text = ([part[name] for part in row["rows"]] for name in ("program", "text"))
        yield Group(
            program, text, frozenset(row.get("without", ())), frozenset(row.get("units", ()))
        )


@lru_cache(maxsize=1)
def swaps() -> Swaps:
    """Return what may be exchanged, read once."""
    path = training_templates() / "query" / "swaps.toml"
    return Swaps(list(_groups(tomllib.loads(path.read_text(encoding="utf-8"))["group"])))
