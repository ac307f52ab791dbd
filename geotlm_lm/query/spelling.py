"""A question, its program and its answer as the tokens of the language model.

The words of texts are byte pairs of its own vocabulary. Behind those ids lie the words of a
program, the slots among them, and beside a number's slot its unit and its size, roughly. A number's
digits are never read nor written: an answer's are copied from the value that it tells.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from tokenizers import Tokenizer

from geotlm_lm.language.size import SLOTS
from geotlm_lm.query.copied import Copied, copied
from geotlm_lm.query.lexicon import Lexicon
from geotlm_lm.query.lines import PROGRAM_WORDS
from geotlm_lm.query.program import MOST_SLOTS, UNITS
from geotlm_lm.query.quantities import Stated, find
from geotlm_lm.query.words import END

UNIT_WORDS = (
    "unit:none",
    "unit:per",
    *(f"unit:{unit}" for units in UNITS.values() for unit in units),
)
SIZES = (0, 1, 2, 45, 90, 180, 270, 360)
"""Values that may mean more than an amount: a mount "turned by 90 degrees"."""
SIZE_WORDS = ("size:negative", "size:other", *(f"size:{size}" for size in SIZES))
READ = "<read>"
"""Ends the question; the query begins."""

SAY = "<say>"
"""Begins the answer."""
SLOT_TOKENS = tuple(f"<{slot}>" for slot in SLOTS)
NUMBERS = tuple(f"={place}" for place in range(1, 10))
"""Numbers of an answer in their order, which are copied from its value."""

WORDS = (READ, END, SAY, *SLOT_TOKENS, *NUMBERS, *PROGRAM_WORDS, *UNIT_WORDS, *SIZE_WORDS)
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_SPACES = re.compile(r"\s+")


@dataclass(frozen=True)
class Spelled:
    """A question for its reader."""

    ids: list[int]  # up to and with `READ`
    quantities: tuple[Stated, ...]  # the quantities that stand as slots, placed in the mended text
    copied: tuple[Copied, ...] = ()  # the words that may be copied, likewise


@dataclass(frozen=True)
class Spelling:
    """Ids of texts and of queries.

    Args:
        tokenizer: Byte pairs of question texts.
        words: All that is not of the text, in the order of their ids.
        lexicon: Words of texts, in whose favour slips of the fingers are mended.
    """

    tokenizer: Tokenizer
    words: tuple[str, ...] = WORDS
    lexicon: Lexicon = Lexicon()

    @cached_property
    def id_of(self) -> dict[str, int]:
        """Id of each word that is not of the text."""
        first = self.tokenizer.get_vocab_size()
        return {word: first + place for place, word in enumerate(self.words)}

    @property
    def size(self) -> int:
        """How many ids there are."""
        return self.tokenizer.get_vocab_size() + len(self.words)

    def question(self, text: str) -> Spelled:
        """Return the ids of a question: mended, lower case, its first numbers as slots."""
        text = self.lexicon.mended(text)
        stated, words = tuple(find(text)[:MOST_SLOTS]), tuple(copied(text)[:MOST_SLOTS])
        marks = [(each.start, each.end, f"#{k}", _beside(each)) for k, each in enumerate(stated, 1)]
        # A word that may be copied is read as well: its place stands before it.
        marks += [(each.start, each.start, f"@{k}", []) for k, each in enumerate(words, 1)]
        ids: list[int] = []
        at = 0
        for start, end, slot, beside in sorted(marks, key=lambda mark: mark[0]):
            ids += self.text(text[at:start])
            ids += [self.id_of[word] for word in (slot, *beside)]
            at = max(at, end)
        ids += self.text(text[at:])
        return Spelled([*ids, self.id_of[READ]], stated, words)

    def query(self, words: Sequence[str]) -> list[int]:
        """Return a query's ids, its end among them."""
        return [self.id_of[word] for word in (*words, END)]

    def sentence(self, text: str) -> list[int] | None:
        """Return an answer's ids from `SAY` to its end; None where it has too many numbers."""
        ids, at = [self.id_of[SAY]], 0
        numbers = list(_NUMBER.finditer(text))
        if len(numbers) > len(NUMBERS):
            return None
        for word, match in zip(NUMBERS, numbers, strict=False):
            ids += [*self.text(text[at : match.start()]), self.id_of[word]]
            at = match.end()
        return [*ids, *self.text(text[at:]), self.id_of[END]]

    def sentence_of(self, ids: Sequence[int], numbers: Sequence[str]) -> str:
        """Return the text of an answer's ids behind `SAY`, with the numbers of its value."""
        first, text = self.tokenizer.get_vocab_size(), ""
        parts: list[int] = []
        for each in (*ids, self.id_of[END]):
            if each < first:
                parts.append(each)
                continue
            text += self.tokenizer.decode(parts) if parts else ""
            parts, word = [], self.words[each - first]
            if word in NUMBERS:
                place = NUMBERS.index(word)
                text += numbers[place] if place < len(numbers) else "?"
        return text

    @staticmethod
    def numbers_of(text: str) -> list[str]:
        """Return the numbers of an answer, which its value gives to the sentence."""
        return _NUMBER.findall(text)

    def text(self, text: str) -> list[int]:
        """Return the byte pairs of a text without numbers."""
        cleaned = cleaned_text(text)
        return self.tokenizer.encode(cleaned).ids if cleaned.strip() else []


def cleaned_text(text: str) -> str:
    """Return a text as it is read: lower case, single spaces."""
    return _SPACES.sub(" ", text).lower()


def plain_parts(text: str) -> list[str]:
    """Return what of a text is read as byte pairs: all but its numbers."""
    ends = [(each.start, each.end) for each in find(text)[:MOST_SLOTS]]
    starts = [0, *(end for _, end in ends)]
    stops = [*(start for start, _ in ends), len(text)]
    return [cleaned_text(text[a:b]) for a, b in zip(starts, stops, strict=True)]


def _beside(placed: Stated) -> list[str]:
    unit, value = placed.quantity.unit, placed.quantity.value
    top, _, bottom = unit.partition("/")
    words = [f"unit:{top}" if top else "unit:none", *(["unit:per"] if bottom else [])]
    size = next((f"size:{each}" for each in SIZES if value == each), "size:other")
    return [*words, "size:negative" if value < 0 else size]
