"""Stream those words of an answer that are final while the model still writes.

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

from geotlm_lm.answering.abstention import contradicts_gel_change, lacks_reference
from geotlm_lm.answering.answer import Encoded, deciding_word
from geotlm_lm.answering.answer_assembly import NEEDS_MORE, is_camera_frame
from geotlm_lm.answering.consistency_check import (
    CHECKED_KINDS,
    answers_unanswerable,
    contradicts_itself,
    contradicts_open_answer,
    ignores_moving_question,
    kind_from_open_answer,
)
from geotlm_lm.answering.model_query import (
    NEVER_ABSTAINED_KINDS,
    Scores,
    is_uncertain,
    query_model,
)
from geotlm_lm.answering.single_direction import (
    AMOUNT_KINDS,
    is_of_other_motion,
    open_answer_motion,
)
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.kinds import is_ruled_out
from geotlm_lm.conversation.motion_answers import ALWAYS_RULE_KINDS, RULE_KINDS
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.language.parse_answer import Slots

Listener = Callable[[str], None]
"""Told each piece of an answer's words."""


class StableWords:
    """Passes on those words of a growing answer that no later word can change.

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
        self._opened = cache(lambda: query_model(bundle, encoded, OPEN_QUESTION))
        self._stands = {
            sentence: slots if is_final_wording(bundle, encoded, question, frame, slots) else None
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
        if slots.kind in AMOUNT_KINDS:
            return is_of_other_motion(slots, open_answer_motion(self._opened()))
        if slots.kind not in CHECKED_KINDS:
            return False
        return contradicts_open_answer(slots, self._opened().slots, self._question, self._frame)


def _is_withheld(slots: Slots, scores: Scores) -> bool:
    if slots.kind in NEVER_ABSTAINED_KINDS:
        return False
    return is_uncertain(slots.kind, deciding_word(slots), scores(slots.kind))


def is_final_wording(
    bundle: Bundle, encoded: Encoded, question: str, frame: FrameSpec, slots: Slots
) -> bool:
    """Tell whether the model's sentence with these slots becomes the answer unchanged."""
    if is_ruled_out(question, slots.kind) or answers_unanswerable(slots, question):
        return False
    if slots.kind in NEEDS_MORE or slots.kind in ALWAYS_RULE_KINDS:
        return False
    if (
        ignores_moving_question(slots, question)
        or kind_from_open_answer(slots, question) is not None
    ):
        return False
    if contradicts_gel_change(encoded, slots) or lacks_reference(encoded, slots):
        return False
    if contradicts_itself(slots, question):
        return False
    if slots.kind in RULE_KINDS and not is_camera_frame(frame):
        return False
    if slots.unit is not None:
        return False
    return not bundle.calibration.withholds(slots.direction, encoded.contact_share)


def answer_pieces(ask: Callable[[Listener], Any]) -> Iterator[Any]:
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
