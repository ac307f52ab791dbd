"""A conversation about clips: its turns, what was stated, and what a follow-up refers to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

from geotlm_lm.answering.answer import Answer, Comparison, Why
from geotlm_lm.answering.argument_checks import require_encoded, require_frame
from geotlm_lm.answering.asked import Asked
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.pipeline import answer, compared
from geotlm_lm.answering.understanding import Understood, understand
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import check_question
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query.phrases import unit_phrase
from geotlm_lm.query.program import Program, asks_of_two, head_of, type_of

Reply = Answer | Comparison


@dataclass(frozen=True)
class Turn:
    """One question and its answer.

    Args:
        question: As it was asked.
        answer: What was said to it.
        frame: The frame of reference before it.
        encoded: The clip that questions were about; None where it has grown and others were asked
            since, of which each would keep its own frames.
        before: What was asked before it.
        named: The point of view that had been named by then.
        place: Of the clip in the conversation, from 0.
    """

    question: str
    answer: Reply
    frame: FrameSpec
    encoded: Encoded | None
    before: Program
    named: str | None
    place: int


class Explaining(Protocol):
    """What a conversation needs of an `Answerer`."""

    bundle: Bundle

    def believing(self, encoded: Encoded) -> Encoded:
        """Return a clip with what makes its belief."""

    def why(self, encoded: Encoded, answer: Answer) -> Why:
        """Return the reasons for an answer."""


class Session:
    """A conversation.

    Args:
        answerer: The model.
        encoded: The clip it begins with.
        frame: The frame of reference it begins with.

    Raises:
        TypeError: If the clip is not encoded, or the frame is none.
    """

    def __init__(self, answerer: Explaining, encoded: Encoded, frame: FrameSpec) -> None:
        require_encoded(encoded)
        require_frame(frame)
        self.answerer = answerer
        self.clips = [answerer.believing(encoded)]
        self.frame = frame
        self.history: list[Turn] = []
        self._before = Program()
        self._named: str | None = None

    @property
    def encoded(self) -> Encoded:
        """The clip that questions are about: the last one given."""
        return self.clips[-1]

    @property
    def last(self) -> Reply | None:
        """The last answer about a clip: neither talk nor a fact."""
        turn = self._last_turn
        return None if turn is None else turn.answer

    @property
    def _last_turn(self) -> Turn | None:
        return next((turn for turn in reversed(self.history) if _is_about_clip(turn.answer)), None)

    def add_clip(self, encoded: Encoded) -> None:
        """Make another clip the one that questions are about; comparisons look back at the last.

        The size of a pixel that was told holds for frames of the same size only, a frame rate for
        clips whose files tell none.

        Raises:
            TypeError: If it is not encoded.
        """
        require_encoded(encoded)
        if encoded.clip.frames.shape[1:3] != self.encoded.clip.frames.shape[1:3]:
            self.frame = replace(self.frame, mm_per_px=None)
        if encoded.clip.fps is not None:
            self.frame = replace(self.frame, rate_hz=None)
        self.clips.append(self.answerer.believing(encoded))
        self._named = None

    def grow(self, encoded: Encoded) -> None:
        """Take a clip for the last one with more frames, as of a camera that goes on.

        What refers to the last answer ("are you sure?") is about what was seen by then.

        Raises:
            TypeError: If it is not encoded.
        """
        require_encoded(encoded)
        self.clips[-1] = self.answerer.believing(encoded)
        last = self._last_turn
        self.history = [
            turn if turn is last else replace(turn, encoded=None) for turn in self.history
        ]

    def ask(self, question: str) -> Reply:
        """Answer the next question.

        Args:
            question: In English, or a fact about the recording.

        Raises:
            UsageError: If the question is empty or too long.
        """
        typed = check_question(question)
        clips = tuple(self.clips[-2:])
        asked = Asked(self.answerer.bundle, clips, self.frame, self._named)
        understood = understand(asked.bundle.reader, typed, self._before, asked)
        about_last = self._about_last(understood)
        if about_last is not None:
            reply: Reply = about_last
        elif len(clips) == 2 and any(map(asks_of_two, understood.program.answers)):
            reply = compared(asked, understood)
        else:
            reply = answer(asked, understood)
        place = len(self.clips) - 1
        turn = Turn(typed, reply, self.frame, self.encoded, self._before, self._named, place)
        self.history.append(turn)
        if isinstance(reply, Answer):
            self._named = reply.point_of_view or self._named
        if understood.ask_back is None:
            self.frame = asked.frame_after(understood.program)
            if _asks(understood.program):
                self._before = understood.program
        return reply

    def _about_last(self, understood: Understood) -> Answer | None:
        """Return what is told of the last answer about this clip: how sure, how near, and why."""
        turn = self._last_turn
        if turn is None or turn.place != len(self.clips) - 1 or understood.ask_back is not None:
            return None
        last, asked = turn.answer, understood.program.answers
        if not isinstance(last, Answer) or len(asked) != 1 or understood.program.form != "sentence":
            return None
        word = asked[0].word
        if word == "why":
            text = " ".join(self.answerer.why(turn.encoded or self.encoded, last).steps)
        elif word == "sure-amount" and last.amount is not None:
            low, high = last.amount.span
            text = f"Nine times in ten it is {low:g} to {high:g}{unit_phrase(last.amount)}."
        elif word in ("sure", "sure-amount"):
            text = (
                last.text
                if last.abstained
                else f"About {last.confidence:.0%}: {_inside(last.text)}"
            )
        else:
            return None
        return replace(last, text=text, kind="talk", query=understood.line)

    def take_back(self, question: str) -> None:
        """Forget the last turn, if this was its question, and what it said about the frame."""
        if self.history and self.history[-1].question == check_question(question):
            turn = self.history.pop()
            self.frame, self._before, self._named = turn.frame, turn.before, turn.named

    def to_dict(self) -> list[dict[str, Any]]:
        """Return the turns as plain JSON values."""
        return [
            {"question": turn.question, "answer": turn.answer.to_dict()} for turn in self.history
        ]


def _inside(sentence: str) -> str:
    """Return a sentence as it stands inside another one."""
    return f"{sentence[:1].lower()}{sentence[1:]}"


def _is_about_clip(reply: Reply) -> bool:
    return reply.kind not in ("fact", "talk")


def _asks(program: Program) -> bool:
    """Tell whether what is asked is what a follow-up leans on: "thanks" and "why?" are not."""
    return any(type_of(head_of(answer)) != "talk" for answer in program.answers)
