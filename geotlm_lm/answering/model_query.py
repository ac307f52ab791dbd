"""Query the language model once: how it understands a question, and its sentence."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np

from geotlm_lm.answering.answer import Answer, deciding_word, offered_letters
from geotlm_lm.answering.belief_of_clip import reading
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.kinds import asked_kind, asks_direction
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


def query_model(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    listen: TextListener | None = None,
) -> ModelReply:
    """Return the model's sentence.

    Where nothing touches, an open question about direction needs no model to be answered; any other
    question does, to be understood. Where the words tell the kind of answer and nobody listens, all
    answers of that kind are weighed first: what would be written is one of them nearly always, and
    then need not be written token by token.

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
    timing: dict[str, float] = {}
    kind = "direction" if asks_direction(question) else asked_kind(question)
    if listen is None and kind in bundle.grammar.kinds:
        started = time.perf_counter()
        text = _weigh(bundle, encoded, question, kind)[1]
        timing["score"] = 1e3 * (time.perf_counter() - started)
        if text is not None:
            return ModelReply(bundle.grammar.parse(text), text, timing)
    started = time.perf_counter()
    told = {} if listen is None else {"listen": listen}
    text = bundle.speaker.generate(reading(encoded)[None], [question], **told)[0]
    timing["generate"] = 1e3 * (time.perf_counter() - started)
    return ModelReply(bundle.grammar.parse(text), text, timing)


def summed_timings(*passes: ModelReply | Answer) -> dict[str, float]:
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
    return _weigh(bundle, encoded, question, kind)[0]


def _weigh(
    bundle: Bundle, encoded: Encoded, question: str, kind: str
) -> tuple[dict[str, float], str | None]:
    """Return the same, and the answer of `kind` that the model writes, None if it writes none."""
    grammar = bundle.grammar
    sentences = grammar.options_for(kind)
    if kind == "choice" and (offered := offered_letters(question)):
        sentences = [s for s in sentences if grammar.parse(s).letter in offered]
    weighed = bundle.speaker.weigh(reading(encoded), question, sentences)
    probabilities = bundle.calibration.probabilities(weighed.log_probabilities, doubt=encoded.doubt)
    options: dict[str, float] = {}
    for sentence, probability in zip(sentences, probabilities, strict=True):
        word = deciding_word(grammar.parse(sentence))
        options[word] = options.get(word, 0.0) + float(probability)
    return options, weighed.written
