"""Read a question: a small decoder writes its query, word by word, of well-formed ones only.

It sees the text and nothing else, so what is read cannot depend on a clip. Question tokens see each
other both ways, as the prefix of a prefix language model (Raffel et al. 2020, T5, 3.2.1).
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tokenizers import Tokenizer

from geotlm_lm.core.errors import IncompatibleBundle, UsageError, first_line
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.language.sequence import Floats, SequenceDecoder, TextCache, log_softmax
from geotlm_lm.language.size import TEXT
from geotlm_lm.query.fitting import fitting
from geotlm_lm.query.lexicon import Lexicon
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import Program, filled
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.spelling import Spelling
from geotlm_lm.query.words import END

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

    def calibrated_as(self, other: Reader) -> Reader:
        """Return the same reader with another's calibration."""
        return Reader(self.decoder, self.spelling, other.calibration)

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
            if not begun.unlikely.isdisjoint(allowed):
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
