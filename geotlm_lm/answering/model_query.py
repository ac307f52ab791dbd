"""Query the language model: how it understands a question, its sentence, or whether it says one."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from geotlm_lm.answering.answer import Answer, deciding_word, offered_letters
from geotlm_lm.answering.belief_of_clip import reading
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.kinds import asks_direction
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots

AMOUNT_QUESTION = "How far did it go?"
RATE_QUESTION = "How fast did it go?"
EVIDENCE_QUESTION = "Which half moves which way?"

TextListener = Callable[[str], None]
"""Told the words so far."""


@dataclass(frozen=True)
class ModelReply:
    """The model's reply: its sentence and its meaning.

    Args:
        slots: What its words claim; None where they are none of the answers.
        text: Its words.
        timing_ms: Milliseconds of each stage.
        is_by_rule: These are not words the model wrote: nothing touches the gel, or they are the
            likeliest of the answers that the question's words allow.
    """

    slots: Slots | None
    text: str
    timing_ms: dict[str, float] = field(default_factory=dict)
    is_by_rule: bool = False

    def written(self, sentences: Sequence[str]) -> str | None:
        """Return which of some sentences it is; None if none."""
        return self.text if self.text in sentences else None


@dataclass(frozen=True)
class ModelCheck:
    """A question that the model need not write an answer to: what it may say is decided first.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What is asked.
        timing_ms: Milliseconds of each stage so far.
    """

    bundle: Bundle
    encoded: Encoded
    question: str
    timing_ms: dict[str, float] = field(default_factory=dict)

    slots = None
    is_by_rule = False

    def written(self, sentences: Sequence[str]) -> str | None:
        """Return which of some sentences the model would write; None if none."""
        started = time.perf_counter()
        reads, writes = reading(self.encoded), self.bundle.speaker.would_write
        found = next((one for one in sentences if writes(reads, self.question, one)), None)
        if sentences:
            took = 1e3 * (time.perf_counter() - started)
            self.timing_ms["check"] = self.timing_ms.get("check", 0.0) + took
        return found


def query_model(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    listen: TextListener | None = None,
) -> ModelReply:
    """Return the model's sentence.

    Where nothing touches, an open question about direction needs no model to be answered; any other
    question does, to be understood.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What to ask.
        listen: Told the words so far, after each token.
    """
    if encoded.is_untouched and asks_direction(question):
        slots = Slots("direction", Motion.NONE)
        text = bundle.grammar.sentence(slots)
        if listen is not None:
            listen(text)
        return ModelReply(slots, text, is_by_rule=True)
    started = time.perf_counter()
    told = {} if listen is None else {"listen": listen}
    text = bundle.speaker.generate(reading(encoded)[None], [question], **told)[0]
    timing = {"generate": 1e3 * (time.perf_counter() - started)}
    return ModelReply(bundle.grammar.parse(text), text, timing)


Heard = ModelReply | ModelCheck
"""What is known of the model's own words."""


def summed_timings(*passes: Heard | Answer) -> dict[str, float]:
    """Return the milliseconds of each stage, summed over several replies."""
    stages = {stage for one in passes for stage in one.timing_ms}
    return {stage: sum(one.timing_ms.get(stage, 0.0) for one in passes) for stage in stages}


def query_likeliest(
    bundle: Bundle, encoded: Encoded, question: str, kinds: Collection[str]
) -> ModelReply:
    """Return the most likely answer of some kinds as if the model had written it.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What to ask.
        kinds: Kinds of the bundle's grammar.
    """
    started = time.perf_counter()
    sentences = [text for kind in sorted(kinds) for text in bundle.grammar.options_for(kind)]
    likelihoods = bundle.speaker.score(reading(encoded), question, sentences)
    text = sentences[int(np.argmax(likelihoods))]
    timing = {"score": 1e3 * (time.perf_counter() - started)}
    return ModelReply(bundle.grammar.parse(text), text, timing, is_by_rule=True)


def score(bundle: Bundle, encoded: Encoded, question: str, kind: str) -> dict[str, float]:
    """Return the calibrated probability of every answer of `kind`, by its deciding word."""
    grammar = bundle.grammar
    sentences = grammar.options_for(kind)
    if kind == "choice" and (offered := offered_letters(question)):
        sentences = [s for s in sentences if grammar.parse(s).letter in offered]
    likelihoods = bundle.speaker.score(reading(encoded), question, sentences)
    probabilities = bundle.calibration.probabilities(likelihoods, doubt=encoded.doubt)
    options: dict[str, float] = {}
    for sentence, probability in zip(sentences, probabilities, strict=True):
        word = deciding_word(grammar.parse(sentence))
        options[word] = options.get(word, 0.0) + float(probability)
    return options
