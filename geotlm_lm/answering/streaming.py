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

from geotlm_lm.answering.answer_assembly import answer_heard
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.model_query import ModelReply
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.frame_spec import FrameSpec

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
        grammar = bundle.grammar
        self._possible = [one for kind in grammar.kinds for one in grammar.options_for(kind)]

        @cache
        def stands(sentence: str) -> bool:
            heard = ModelReply(grammar.parse(sentence), sentence)
            answer = answer_heard(bundle, encoded, question, frame, heard)
            return answer.text == sentence and answer.told_by == "model"

        self._stands = stands

    def __call__(self, text: str) -> None:
        """Take the text so far."""
        self._possible = [one for one in self._possible if one.startswith(text)]
        if (
            len(text) > len(self._told)
            and self._possible
            and all(map(self._stands, self._possible))
        ):
            self._tell(text[len(self._told) :])
            self._told = text


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
