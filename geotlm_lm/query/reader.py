"""Read a question: a small decoder writes its program, word by word, of well-formed ones only.

It sees the text and nothing else, so what is read cannot depend on a clip. Question tokens see each
other both ways, as the prefix of a prefix language model (Raffel et al. 2020, T5, 3.2.1).

The words of texts are byte pairs of its own vocabulary. Behind those ids lie the words of a
program, the slots among them, and beside a number's slot its unit and its size, roughly. A number's
digits are never read nor written: an answer's are copied from the value that it tells.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from string import ascii_lowercase
from typing import Any, NamedTuple

import numpy as np
from tokenizers import Tokenizer

from geotlm_lm.core.errors import IncompatibleBundle, UsageError, first_line
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.process import in_one_thread
from geotlm_lm.language.sequence import Floats, SequenceDecoder, TextCache, log_softmax
from geotlm_lm.language.size import SLOTS, TEXT
from geotlm_lm.query.copied import Copied, copied
from geotlm_lm.query.lines import END, PROGRAM_WORDS, fitting, read
from geotlm_lm.query.phrases import with_plurals, with_singulars
from geotlm_lm.query.program import MOST_COPIED, MOST_SLOTS, UNITS, Program, filled
from geotlm_lm.query.quantities import Quantity, Stated, find

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
        ranks = (self._rank.get(meant, self.frequent) for meant in slipped_from(word))
        place = min(ranks, default=0)
        return self.words[place] if place < self.frequent else written


def slipped_from(word: str) -> Iterator[str]:
    """Yield what a word may be a slip of."""
    for at in range(len(word) - 1):
        yield word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    if len(word) + 1 >= SHORTEST_WHOLE:
        for at in range(1, len(word)):
            yield from (word[:at] + letter + word[at:] for letter in ascii_lowercase)


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
MISSING = "\N{HORIZONTAL ELLIPSIS}"
"""Stands in an answer for a number that its value does not hold, and for what is left out."""

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

    @cached_property
    def _places(self) -> int:
        """How many words may be copied: an older model knows fewer places."""
        return sum(f"@{place}" in self.id_of for place in range(1, MOST_COPIED + 1))

    def question(self, text: str) -> Spelled:
        """Return the ids of a question: mended, lower case, its first numbers as slots."""
        text = self.lexicon.mended(text)
        stated, words = tuple(find(text)[:MOST_SLOTS]), tuple(copied(text)[: self._places])
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
        ids, at, text = [self.id_of[SAY]], 0, with_plurals(text)
        numbers = list(_NUMBER.finditer(text))
        if len(numbers) > len(NUMBERS):
            return None
        for word, match in zip(NUMBERS, numbers, strict=False):
            ids += [*self.text(text[at : match.start()]), self.id_of[word]]
            at = match.end()
        return [*ids, *self.text(text[at:]), self.id_of[END]]

    def sentence_of(self, ids: Sequence[int], value: str) -> str:
        """Return the text of an answer's ids behind `SAY`, with its value's numbers."""
        numbers, first, text = _NUMBER.findall(value), self.tokenizer.get_vocab_size(), ""
        parts: list[int] = []
        for each in (*ids, self.id_of[END]):
            if each < first:
                parts.append(each)
                continue
            text += self.tokenizer.decode(parts) if parts else ""
            parts, word = [], self.words[each - first]
            if word in NUMBERS:
                place = NUMBERS.index(word)
                text += numbers[place] if place < len(numbers) else MISSING
        return with_singulars(text)

    def text(self, text: str) -> list[int]:
        """Return the byte pairs of a text without numbers."""
        cleaned = cleaned_text(text)
        return self.tokenizer.encode(cleaned).ids if cleaned.strip() else []


def cleaned_text(text: str) -> str:
    """Return a text as it is read: lower case, single spaces."""
    return _SPACES.sub(" ", text).lower()


def _beside(placed: Stated) -> list[str]:
    unit, value = placed.quantity.unit, placed.quantity.value
    top, _, bottom = unit.partition("/")
    words = [f"unit:{top}" if top else "unit:none", *(["unit:per"] if bottom else [])]
    size = next((f"size:{each}" for each in SIZES if value == each), "size:other")
    return [*words, "size:negative" if value < 0 else size]


SPELLING_FILE = "spelling.json"

MOST_SAID = 80
"""Tokens of an answer that the model says itself, at most."""

MOST_WORDS = 80
DOUBTFUL = 0.02
"""Share of its best word's probability from which on another word is worth a second reading."""

SURE = 0.85
"""Probability of a reading from which on no other one is looked at."""
MOST = 5
"""How many readings are looked at where the first is not sure."""


OUT_OF_PLACE = 0.05
"""How much less likely a question of two recordings is where one is open, and one that leans on
the question before where none was asked."""


@dataclass(frozen=True)
class Reading:
    """What a question was taken to mean."""

    line: str  # the program's words, numbers and copied words as slots
    quantities: tuple[Quantity, ...]  # numbers of the question, for the slots
    texts: tuple[str, ...]  # its words that may be copied
    probability: float  # that this is what was meant, calibrated
    chance: float  # that the model writes it, not calibrated

    @property
    def program(self) -> Program:
        """The program with the question's numbers and words."""
        return filled(read(self.line), self.quantities, self.texts)


class _Begun(NamedTuple):
    """A question that was seen: the last hidden state, keys and values, and their number."""

    hidden: Floats
    cache: TextCache
    length: int
    unlikely: frozenset[str]  # words of programs that are out of place


def _weighed(scores: Floats, is_unlikely: Sequence[bool]) -> Floats:
    """Return log-probabilities with some less likely, together what they were."""
    weighed = np.where(is_unlikely, scores + math.log(OUT_OF_PLACE), scores)
    return weighed + np.logaddexp.reduce(scores) - np.logaddexp.reduce(weighed)


class Reader:
    """Reads questions.

    Args:
        decoder: The language model's weights.
        spelling: Their ids.
        calibration: (slope, offset) of the log-odds of a reading's probability.
    """

    def __init__(
        self, decoder: SequenceDecoder, spelling: Spelling, calibration: tuple[float, float]
    ) -> None:
        self.decoder, self.spelling, self.calibration = decoder, spelling, calibration

    def read(self, text: str) -> Reading:
        """Return the most probable reading of a question.

        Raises:
            UsageError: If the question is empty or too long.
        """
        return self.readings(text)[0]

    @in_one_thread()
    def readings(
        self,
        text: str,
        most: int = MOST,
        sure: float = SURE,
        unlikely: frozenset[str] = frozenset(),
    ) -> list[Reading]:
        """Return the most probable readings, the best first; less probable ones turn off from it.

        Args:
            text: The question.
            most: How many at most.
            sure: Probability of the best one from which on no other is looked at.
            unlikely: Words that are out of place here.

        Raises:
            UsageError: If the question is empty or too long.
        """
        spelled = self.spelling.question(text)
        if len(spelled.ids) < 2:
            raise UsageError(
                "The question is empty; ask something like 'Which way is it turning?'."
            )
        room = self.decoder.size.max_tokens - TEXT - MOST_WORDS - MOST_SAID
        if len(spelled.ids) > room:
            fitting = max(int(len(text) * 0.9 * room / len(spelled.ids)), 1)
            raise UsageError(
                f"The question has {len(text)} characters, expected at most about {fitting} of "
                f"this kind; shorten it."
            )
        numbers = tuple(each.quantity for each in spelled.quantities)
        cache = self.decoder.started(len(spelled.ids) + MOST_WORDS)
        embedded = self.decoder.embeddings[spelled.ids]
        both_ways = np.ones((len(embedded), len(embedded)), bool)
        hidden = self.decoder.read(embedded, cache, both_ways)[-1]
        begun = _Begun(hidden, cache, cache.length, unlikely)
        texts = tuple(each.text for each in spelled.copied)
        words, chance, others = self._written(begun, [], numbers, len(texts))
        lines = [(words, chance)]
        if self.calibrated(chance) < sure:
            for beginning, share in sorted(others, key=lambda each: -each[1])[: most - 1]:
                rest, other, _ = self._written(begun, beginning, numbers, len(texts))
                lines.append((rest, min(other, share)))
        readings = [
            Reading(" ".join(words), numbers, texts, self.calibrated(chance), chance)
            for words, chance in lines
        ]
        return sorted(readings, key=lambda reading: -reading.chance)

    def calibrated(self, chance: float) -> float:
        """Return the calibrated probability of readings that the model writes with a chance."""
        slope, offset = self.calibration
        chance = min(max(chance, 1e-6), 1 - 1e-6)
        return 1 / (1 + math.exp(-(slope * math.log(chance / (1 - chance)) + offset)))

    def _written(
        self,
        begun: _Begun,
        beginning: Sequence[str],
        numbers: Sequence[Quantity],
        texts: int,
    ) -> tuple[list[str], float, list[tuple[list[str], float]]]:
        """Return a query's words behind a beginning, its probability, and turnings off it."""
        hidden, cache, words = begun.hidden, begun.cache, []
        cache.length = begun.length
        log_chance = 0.0
        others: list[tuple[list[str], float]] = []
        while len(words) < MOST_WORDS:
            allowed = sorted(fitting(words, numbers, texts) & self.spelling.id_of.keys())
            ids = [self.spelling.id_of[word] for word in allowed]
            scores = log_softmax(self.decoder.logits(hidden))[ids]
            # "mirrored" is a fact as well as a comparison of two.
            if not begun.unlikely.isdisjoint(allowed) and "turned" not in allowed:
                scores = _weighed(scores, [word in begun.unlikely for word in allowed])
            order = (-scores).argsort(kind="stable")
            best = int(order[0])
            if len(words) < len(beginning):
                best = allowed.index(beginning[len(words)])
            elif len(order) > 1 and scores[order[1]] - scores[best] > math.log(DOUBTFUL):
                other = [*words, allowed[order[1]]]
                if other[-1] != END:
                    others.append((other, math.exp(log_chance + float(scores[order[1]]))))
            log_chance += float(scores[best])
            if allowed[best] == END:
                return words, math.exp(log_chance), others
            words.append(allowed[best])
            hidden = self.decoder.read(self.decoder.embeddings[[ids[best]]], cache)[0]
        return ["not-understood"], 0.0, others

    def save(self, folder: Path) -> None:
        """Write the decoder, and beside it what reads and writes its ids, each file atomically."""
        self.decoder.save(folder)
        write_text_atomically(folder / "tokenizer.json", self.spelling.tokenizer.to_str())
        about = {
            "calibration": list(self.calibration),
            "words": list(self.spelling.words),
            "lexicon": " ".join(self.spelling.lexicon.words),
            "frequent_words": self.spelling.lexicon.frequent,
        }
        write_text_atomically(folder / SPELLING_FILE, json.dumps(about, indent=2) + "\n")

    @classmethod
    def load(cls, folder: Path) -> Reader:
        """Read a language model's folder.

        Raises:
            IncompatibleBundle: If a file is missing or broken, or knows other words.
        """
        try:
            spelling, about = spelled_by(folder)
            decoder = SequenceDecoder.load(folder)
            if decoder.vocabulary != spelling.size:
                raise ValueError(f"{decoder.vocabulary} ids for {spelling.size} words")
            slope, offset = map(float, about["calibration"])
        except Exception as error:  # tokenizers raises nothing narrower
            raise IncompatibleBundle(
                f"{folder}: the language model's files are missing, broken or do not belong "
                f"together ({first_line(error)}); save or download the model again."
            ) from error
        return cls(decoder, spelling, (slope, offset))


def spelled_by(folder: Path) -> tuple[Spelling, dict[str, Any]]:
    """Return the ids of a language model's folder, and what else is told there."""
    about = json.loads((folder / SPELLING_FILE).read_text(encoding="utf-8"))
    tokenizer = Tokenizer.from_file(str(folder / "tokenizer.json"))
    lexicon = Lexicon(tuple(about["lexicon"].split()), int(about["frequent_words"]))
    return Spelling(tokenizer, tuple(about["words"]), lexicon), about
