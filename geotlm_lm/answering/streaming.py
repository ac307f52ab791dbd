"""Words as they are generated, as far as they will stand in the answer.

Most answers are the model's own sentence and may be told while it is written. Others are derived
from it by rule, are measured, or are withheld for want of contact or certainty: of these
nothing is told before the end. Which it will be is known from the first words on, because every
answer is one of a closed set of sentences.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from queue import SimpleQueue
from threading import Thread
from typing import Any

from geotlm_lm.answering.answer import Encoded, deciding_word
from geotlm_lm.answering.hearing import (
    NEVER_DOUBTED,
    Scores,
    hear,
    is_doubtful,
)
from geotlm_lm.answering.one_way import MEASURED, goes_another_way, told_motion
from geotlm_lm.answering.overruling import (
    CHECKED,
    answers_what_it_cannot,
    asked_openly,
    contradicts_itself,
    denies_the_open_answer,
    passes_over_moving,
)
from geotlm_lm.answering.replying import NEEDS_MORE, is_as_seen
from geotlm_lm.answering.withholding import is_contradicted, is_unfounded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.kinds import is_ruled_out
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.retell import ALWAYS_RETOLD, RETOLD
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.language.parse_answer import Slots

Listener = Callable[[str], None]
"""Told each piece of an answer's words."""


class StandingWords:
    """Hands on those words that will stand, whatever comes after them.

    Args:
        bundle: The model that writes them; its grammar holds every sentence there may be.
        encoded: The clip they are about.
        question: What they answer.
        frame: The frame they are to be told in.
        tell: Told each piece.
    """

    def __init__(
        self, bundle: Bundle, encoded: Encoded, question: str, frame: FrameSpec, tell: Listener
    ) -> None:
        self._tell, self._told = tell, ""
        self._question, self._frame = question, frame
        self._opened = cache(lambda: hear(bundle, encoded, OPEN_QUESTION))
        self._stands = {
            sentence: slots if stands(bundle, encoded, question, frame, slots) else None
            for kind in bundle.grammar.kinds
            for sentence in bundle.grammar.options_for(kind)
            for slots in [bundle.grammar.parse(sentence)]
        }

    def __call__(self, text: str, scores: Scores) -> None:
        """Take the text so far, and where to learn how likely it is."""
        possible = [slots for sentence, slots in self._stands.items() if sentence.startswith(text)]
        if not possible or not all(possible) or len(text) <= len(self._told):
            return
        if len({slots.kind for slots in possible}) > 1:
            return  # to weigh the answers of several kinds takes longer than the next word
        if any(self._denies_the_open_answer(slots) for slots in possible):
            return
        if not any(_is_withheld(slots, scores) for slots in possible):
            self._tell(text[len(self._told) :])
            self._told = text

    def _denies_the_open_answer(self, slots: Slots) -> bool:
        if slots.kind in MEASURED:
            return goes_another_way(slots, told_motion(self._opened()))
        if slots.kind not in CHECKED:
            return False
        return denies_the_open_answer(slots, self._opened().slots, self._question, self._frame)


def _is_withheld(slots: Slots, scores: Scores) -> bool:
    if slots.kind in NEVER_DOUBTED:
        return False
    return is_doubtful(slots.kind, deciding_word(slots), scores(slots.kind))


def stands(bundle: Bundle, encoded: Encoded, question: str, frame: FrameSpec, slots: Slots) -> bool:
    """Tell whether a sentence of the model with these slots becomes the answer as it is."""
    if is_ruled_out(question, slots.kind) or answers_what_it_cannot(slots, question):
        return False
    if slots.kind in NEEDS_MORE or slots.kind in ALWAYS_RETOLD:
        return False
    if passes_over_moving(slots, question) or asked_openly(slots, question) is not None:
        return False
    if is_contradicted(encoded, slots) or is_unfounded(encoded, slots):
        return False
    if contradicts_itself(slots, question):
        return False
    if slots.kind in RETOLD and not is_as_seen(frame):
        return False
    if slots.unit is not None:
        return False
    return not bundle.calibration.withholds(slots.direction, encoded.contact_share)


def pieces(ask: Callable[[Listener], Any]) -> Iterator[Any]:
    """Yield the text of an answer piece by piece, and last the answer.

    The pieces together are the answer's text. Only where the model begins a sentence and then ends
    it as none of its answers is the text another one than they began; the answer's own text counts.

    Args:
        ask: Answers, telling its listener the words as they come.
    """
    waiting: SimpleQueue[tuple[str, Any]] = SimpleQueue()

    def run() -> None:
        try:
            waiting.put(("answer", ask(lambda piece: waiting.put(("piece", piece)))))
        except BaseException as error:  # raised again where the pieces are awaited
            waiting.put(("error", error))

    # Python waits for it at its end: a thread inside the model's libraries cannot be cut off.
    Thread(target=run, daemon=False).start()
    told = ""
    while True:
        what, value = waiting.get()
        if what == "error":
            raise value
        if what == "answer":
            break
        told += value
        yield value
    if value.text.startswith(told) and value.text != told:
        yield value.text[len(told) :]
    yield value
