"""A conversation about clips: its turns, its frame, and what doubts and repetitions refer to.

The language model hears one question at a time and no history: what a turn needs from the turns
before it is exact (the frame, the last answer and its probability), so rules keep it. A doubt
repeats the answer with its probability and never turns it around: being asked twice is no evidence.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.argument_checks import require_encoded, require_frame
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.multi_clip import Comparison, Order
from geotlm_lm.answering.streaming import Listener, answer_pieces
from geotlm_lm.conversation.alternatives import asks_alternatives
from geotlm_lm.conversation.amount_questions import asks_range
from geotlm_lm.conversation.clip_names import clips_by_number
from geotlm_lm.conversation.compound_questions import split_questions
from geotlm_lm.conversation.courtesies import without_courtesies
from geotlm_lm.conversation.follow_ups import asks_again_now, asks_where, follow_up_of
from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.image_rotation import unclear_rotation
from geotlm_lm.conversation.kinds import asked_kind, asks_direction
from geotlm_lm.conversation.likelihood_questions import likelihood_subject
from geotlm_lm.conversation.motion_answers import CAMERA
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.pixel_scale import with_pixel_size
from geotlm_lm.conversation.question import check_question
from geotlm_lm.conversation.requested_units import with_unit
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.conversation.two_clip_claims import asks_of_two
from geotlm_lm.conversation.two_clip_questions import asks_of_one
from geotlm_lm.conversation.wording import confidence_level
from geotlm_lm.core.frame_spec import FrameSpec

_PHRASES = Phrases("session")
Reply = Answer | Comparison | Order

_DOUBT = _PHRASES.pattern("DOUBT")
_ENDS = re.compile(r"[,;.!?]+")
_AGAIN = _PHRASES.pattern("AGAIN")

OF_THE_CLIP_BEFORE = "Of the clip before:"
"""Said where an answer is repeated, or reasoned for, after another clip was given."""

_TELL_A_WAY = ("direction", "verify", "actor", "viewpoint")
"""Kinds of answers that may be told for one question in a view, or of a mover, of its own."""

_STANCE = {
    "high": "I stay with it",
    "medium": "I lean to it",
    "low": "I am not sure of it, but it is the likeliest",
}


@dataclass(frozen=True)
class Turn:
    """One question and its answer.

    Args:
        question: As it was asked.
        answer: What was said to it.
        is_repeated: Whether it is an earlier answer said again.
        frame: The frame of reference before it.
        encoded: The clip that questions were about.
        meant: The question as it was understood: a whole one, without what it says of the frame.
    """

    question: str
    answer: Reply
    is_repeated: bool = False
    frame: FrameSpec = CAMERA
    encoded: Encoded | None = None
    meant: str = ""


class ClipAnswerer(Protocol):
    """What a conversation needs of a model; `Answerer` has it, and begins conversations itself."""

    def ask(
        self, encoded: Encoded, question: str, *, frame: FrameSpec, listen: Listener | None
    ) -> Answer:
        """Answer a question about one clip."""
        ...

    def compare(
        self, first: Encoded, second: Encoded, question: str, *, frame: FrameSpec
    ) -> Comparison:
        """Answer a question about two clips."""
        ...

    def order(self, parts: Sequence[Encoded], *, frame: FrameSpec) -> Order:
        """Name the motions of several clips in their order."""
        ...


class Session:
    """A conversation.

    Args:
        answerer: The model.
        encoded: The clip it begins with.
        frame: The frame of reference it begins with.

    Raises:
        TypeError: If the clip is not encoded, or the frame is none.
    """

    def __init__(self, answerer: ClipAnswerer, encoded: Encoded, frame: FrameSpec = CAMERA) -> None:
        require_encoded(encoded)
        require_frame(frame)
        self.answerer = answerer
        self.clips = [encoded]
        self.frame = frame
        self.history: list[Turn] = []

    @property
    def encoded(self) -> Encoded:
        """The clip that questions are about: the last one given."""
        return self.clips[-1]

    @property
    def last(self) -> Reply | None:
        """The last answer of its own, about a clip: neither about the frame nor a reason."""
        turn = self.last_turn
        return None if turn is None else turn.answer

    @property
    def last_turn(self) -> Turn | None:
        """The turn of `last`: its clip need not be the one that questions are about now."""
        own = (turn for turn in reversed(self.history) if not turn.is_repeated)
        kinds = ("frame", "evidence")
        return next((one for one in own if getattr(one.answer, "kind", "") not in kinds), None)

    def add_clip(self, encoded: Encoded) -> None:
        """Make another clip the one that questions are about; comparisons look back at the last.

        The size of a pixel that was told holds for frames of the same size only.

        Raises:
            TypeError: If it is not encoded.
        """
        require_encoded(encoded)
        if encoded.clip.frames.shape[1:3] != self.encoded.clip.frames.shape[1:3]:
            self.frame = replace(self.frame, mm_per_px=None)
        self.clips.append(encoded)

    def ask(self, question: str, *, listen: Listener | None = None) -> Reply:
        """Answer the next question.

        Args:
            question: In English, or a fact about the recording.
            listen: Told the model's words piece by piece, as far as they stand in the answer.

        Raises:
            UsageError: If the question is empty or too long.
        """
        typed = check_question(question)
        question = self._tied(without_courtesies(typed))
        question = with_pixel_size(question, self.encoded.clip.frames.shape[2])
        question = without_leading_no(question, self.frame)
        amount = getattr(self.last, "amount", None)
        question = question if amount is None else with_unit(question, amount.unit)
        repeated = self._said_again(question)
        answer = repeated or self._reply(question, listen)
        stated, is_repeated = read_facts(question, self.frame), repeated is not None
        turn = Turn(typed, answer, is_repeated, self.frame, self.encoded, stated.rest)
        self.history.append(turn)
        self.frame = stated.lasting
        return answer

    def take_back(self, question: str) -> None:
        """Forget the last turn, if this was its question, and what it said about the frame."""
        if self.history and self.history[-1].question == check_question(question):
            self.frame = self.history.pop().frame

    def stream(self, question: str) -> Iterator[str | Reply]:
        """Yield the reply's text piece by piece as it is generated, and last the reply.

        Raises:
            UsageError: As `ask` does, at the first piece.
        """
        return answer_pieces(lambda listen: self.ask(question, listen=listen))

    def to_dict(self) -> list[dict[str, Any]]:
        """Return the turns as plain JSON values."""
        return [
            {"question": turn.question, "answer": turn.answer.to_dict()} for turn in self.history
        ]

    def _tied(self, question: str) -> str:
        """Return what a question asks that is whole only with the one before it."""
        turn = self.last_turn
        if turn is not None and asks_again_now(question):
            is_noted = getattr(self.history[-1].answer, "kind", None) == "frame"
            if is_noted or turn.encoded is not self.encoded:
                return turn.meant
        if asks_range(question) and getattr(self.last, "kind", None) in ("magnitude", "rate"):
            return turn.meant
        if getattr(self.last, "kind", None) == "contact" and asks_where(question):
            return "Where is the contact?"
        is_fact = read_facts(question, self.frame).is_stated
        return follow_up_of(question, None if turn is None or is_fact else turn.meant)

    def _said_again(self, question: str) -> Reply | None:
        """Return the last answer again where the question doubts it or asks for it; else None."""
        last, words = self._last_said(), normalised_text(question)
        if last is None or (len(self.clips) > 1 and asks_of_one(question) is not None):
            return None
        if _AGAIN.fullmatch(words):
            return last
        asks_surety = asked_kind(question) == "confidence" and split_questions(question) is None
        is_doubt = _is_doubt(words) or (asks_surety and likelihood_subject(question) is None)
        return _reaffirmed(last) if is_doubt else None

    def _last_said(self) -> Reply | None:
        """Return the last answer; where it is of a clip before, its text says so."""
        turn = self.last_turn
        if turn is None or turn.encoded is self.encoded or not isinstance(turn.answer, Answer):
            return turn and turn.answer
        return replace(turn.answer, text=f"{OF_THE_CLIP_BEFORE} {turn.answer.text}")

    def _reply(self, question: str, listen: Listener | None) -> Reply:
        stated = read_facts(question, self.frame)
        is_unclear = unclear_rotation(stated.rest) is not None
        kind = None if is_unclear else asked_kind(stated.rest)
        is_of_one = (
            kind != "order"
            and not is_unclear
            and asks_of_one(clips_by_number(stated.rest)) is not None
        )
        is_of_two = is_of_one or (kind != "order" and not is_unclear and asks_of_two(stated.rest))
        if (kind == "comparison" or is_of_two) and len(self.clips) > 1:
            first, second = self.clips[-2:]
            return self.answerer.compare(first, second, stated.rest, frame=stated.frame)
        if kind == "order" and len(self.clips) > 1:
            return self.answerer.order(self.clips, frame=stated.frame)
        frame = self._frame_of_last() if asks_alternatives(stated.rest) else self.frame
        return self.answerer.ask(self.encoded, question, frame=frame, listen=listen)

    def _frame_of_last(self) -> FrameSpec:
        """Return the frame with the view, and whose motion, that the last way was told in."""
        last = self.last
        if not isinstance(last, Answer) or last.kind not in _TELL_A_WAY:
            return self.frame
        told = last.frame
        return replace(self.frame, viewpoint=told.viewpoint, actor=told.actor)


_CONTRADICTS = _PHRASES.pattern("CONTRADICTS", re.IGNORECASE)


def without_leading_no(question: str, frame: FrameSpec) -> str:
    """Return a text without the "no" before it, where a fact or another question follows.

    "No, the image is mirrored." is more than a doubt.
    """
    rest = _CONTRADICTS.sub("", question)
    asks = asked_kind(rest) not in (None, "confidence") or asks_direction(rest)
    states = read_facts(rest, frame).is_stated or unclear_rotation(rest) is not None
    return rest if rest and (states or asks) else question


def _is_doubt(words: str) -> bool:
    """Tell whether a text is a doubt, or nothing but doubts: "you are wrong, look again!"."""
    clauses = [clause.strip() for clause in _ENDS.split(words) if clause.strip()]
    return bool(_DOUBT.fullmatch(words)) or bool(
        clauses and all(_DOUBT.fullmatch(clause) for clause in clauses)
    )


def _reaffirmed(last: Reply) -> Reply:
    """Return the answer again, with how sure it is."""
    if last.abstained or getattr(last, "kind", None) == "confidence":
        return last
    sure = _STANCE[confidence_level(last.confidence)]
    return replace(last, text=f"{sure}, {last.confidence:.0%}: {last.text}")
