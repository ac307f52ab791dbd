"""Speak for the language model: what it feels at its slots, and what it says of a clip itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.process import in_one_thread
from geotlm_lm.language.sequence import Floats, SequenceDecoder, TextCache, log_softmax
from geotlm_lm.language.size import SLOTS
from geotlm_lm.query.reader import END, MISSING, MOST_SAID, READ, SAY, SLOT_TOKENS, Spelling


@dataclass(frozen=True, eq=False)
class TactilePrefix:
    """A clip as the language model sees it: its tactile prefix and slots.

    Args:
        cache: Them as a sequence.
        slots: Of each slot the log-probabilities of its words, in the order of `SLOTS`.
    """

    cache: TextCache
    slots: dict[str, Floats]


class Speaker:
    """Speaks for the language model.

    Args:
        decoder: Its weights.
        spelling: Its ids.
    """

    def __init__(self, decoder: SequenceDecoder, spelling: Spelling) -> None:
        self.decoder, self.spelling = decoder, spelling
        self._slots = [spelling.id_of[token] for token in SLOT_TOKENS]

    @in_one_thread()
    def prefix(self, numbers: NDArray[np.floating]) -> TactilePrefix:
        """Return a clip's tactile prefix and slots.

        Args:
            numbers: The fused token and what is believed, (clip width,), unitless.

        Raises:
            ValueError: If the shape is another, or a number is not finite.
        """
        numbers = np.asarray(numbers, np.float32)
        if numbers.shape != (self.decoder.clip_width,) or not np.isfinite(numbers).all():
            raise ValueError(
                f"a clip was read as {numbers.shape} numbers, expected "
                f"({self.decoder.clip_width},), all finite"
            )
        cache, logits = self.decoder.prefixed(numbers, self._slots)
        ids = ([self.spelling.id_of[word] for word in words] for words in SLOTS.values())
        slots = {
            slot: log_softmax(row[among])
            for slot, row, among in zip(SLOTS, logits, ids, strict=True)
        }
        return TactilePrefix(cache, slots)

    @in_one_thread()
    def says(self, prefix: TactilePrefix, question: str, line: str, text: str) -> bool:
        """Tell whether an answer, its numbers aside, is what the model says, word for word.

        One pass tells it: the model's likeliest next token is that of the text at every place.
        """
        ids = self.spelling.sentence(text)
        if ids is None or len(ids) > MOST_SAID:
            return False
        before = self._asked(question, line)
        hidden = self._read(prefix, before, ids[:-1])[0][len(before) :]
        return self.decoder.logits(hidden).argmax(axis=1).tolist() == ids[1:]

    @in_one_thread()
    def sentence(self, prefix: TactilePrefix, question: str, line: str, value: str) -> str:
        """Return what the model says, with the numbers of a value as it is worded.

        `MISSING` stands for numbers that the value does not hold, and behind what has no end.
        """
        begin = self.spelling.id_of[SAY]
        hidden, cache = self._read(prefix, self._asked(question, line), [begin])
        written: list[int] = []
        while len(written) < MOST_SAID:
            written.append(int(self.decoder.logits(hidden[-1]).argmax()))
            if written[-1] == self.spelling.id_of[END]:
                break
            hidden = self.decoder.speak(self.decoder.embeddings[written[-1:]], cache)
        is_over = written[-1] == self.spelling.id_of[END]
        return self.spelling.sentence_of(written, value) + MISSING * (not is_over)

    def _asked(self, question: str, line: str) -> list[int]:
        return self.spelling.question(question).ids + self.spelling.query(line.split())

    def _read(
        self, prefix: TactilePrefix, asked: Sequence[int], sentence: Sequence[int]
    ) -> tuple[Floats, TextCache]:
        """Return the hidden states of question, program and sentence behind a clip."""
        ids, clip = [*asked, *sentence], prefix.cache.length
        cache = prefix.cache.copied(len(ids) + MOST_SAID)
        sight = np.tri(len(ids), clip + len(ids), clip, dtype=bool)
        read = asked.index(self.spelling.id_of[READ]) + 1
        sight[: len(asked), :clip] = False  # question and program are blind to the clip
        sight[:read, clip : clip + read] = True
        return self.decoder.speak(self.decoder.embeddings[ids], cache, sight), cache
