"""Conditions on a running camera: a question that is answered yes or no, evaluated at every frame.

A verdict rests on the frames up to its own and on nothing later. What it is of, unless asked
otherwise, is the time since watching began: "it has turned 30 degrees" holds from the moment on at
which it has.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from geotlm_lm.answering.understanding import understand
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import UsageError, check_question
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.answers import answer, chance_of
from geotlm_lm.query.evaluate import Context, Evidence, Untold
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.program import (
    EVENTS,
    GOING,
    Expression,
    Program,
    head_of,
    measure_of,
    of,
    type_of,
)
from geotlm_lm.query.replies import replies
from geotlm_lm.query.restated import restated
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Unknown
from geotlm_lm.query.worlds import with_own_motion, worlds_of_track
from geotlm_lm.query.written import worded
from geotlm_lm.track.events import Event, EventKind, Span
from geotlm_lm.track.summed import belief_of_track
from geotlm_lm.track.track import Track

SURE, UNSURE = 0.95, 0.5
"""Probability from which on a condition holds, and below which it holds no more: between the two it
stays as it is, so that noise does not make it flicker."""

READ = 0.7
"""Least probability of a reading: a condition moves a robot, as facts turn a direction."""

OF_DEPTH = ("press", "in", "out", "move", "still", "any", "pause")
"""Words of programs that a press changes."""

NEEDS = ("scale", "thread", "side", "unit", "pixel", "second", "before", "rate", "share", "place")
"""Reasons for which a condition could never be told, whatever happens."""

Whose = Literal["object", "contact"]
"""What moves: the object in the world, by the sensor's own motion and its motion relative to it, or
the object relative to the sensor."""


@dataclass(frozen=True)
class Condition:
    """A condition as it was understood.

    Args:
        text: As it was typed.
        holds: The expression.
        frame: In which directions are meant.
        probability: That this is what was meant.
        restated: How it was read, in words.
    """

    text: str
    holds: Expression
    frame: FrameSpec
    probability: float
    restated: str

    @property
    def is_of_depth(self) -> bool:
        """Whether it asks how deep something goes, which the model alone can tell."""
        words = {name for each in self.holds for name in (each.word, *each.arguments)
                 if isinstance(name, str)}  # fmt: skip
        return any(word.removesuffix(EVENTS) in OF_DEPTH for word in words)


@dataclass(frozen=True, eq=False)
class Verdict:
    """Whether a condition holds at a frame.

    Args:
        time_s: When the frame was taken, on the stream's clock.
        number: Of the frame, counted from 0.
        probability: That the condition holds; None where that cannot be told yet.
        holds: Whether it has held with the wanted probability for the wanted time.
        is_new: Whether it holds since this frame.
        is_relative: Whether what moves is told relative to the sensor, whose own motion is unknown.
        latency_ms: From the frame to the verdict.
        evidence: What it rests on; `text` words it.
    """

    time_s: float
    number: int
    probability: float | None
    holds: bool
    is_new: bool
    is_relative: bool
    latency_ms: float
    evidence: Callable[[], str] = field(repr=False)

    @property
    def text(self) -> str:
        """What the verdict rests on, in words: "Yes: it turns clockwise, about 31 degrees."."""
        return self.evidence()

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "time_s": round(self.time_s, 4),
            "frame": self.number,
            "holds": self.holds,
            "probability": None if self.probability is None else round(self.probability, 3),
            "evidence": self.text,
            "relative_to_sensor": self.is_relative,
            "latency_ms": round(self.latency_ms, 1),
        }


def condition_of(bundle: Bundle, text: str, frame: FrameSpec, *, is_negated: bool) -> Condition:
    """Return a condition as it is understood, before any frame is seen.

    Args:
        bundle: Reads it.
        text: "it has turned 30 degrees clockwise", "it slips".
        frame: In which directions are meant; facts that the text states are added.
        is_negated: Whether the contrary is waited for, as of "while it does not slip".

    Raises:
        UsageError: If it is not surely understood, is no yes or no, or could never be told.
    """
    understood = understand(bundle.reader, check_question(text), is_condition=True)
    program = understood.program
    words = restated(program) if program.answers or program.facts else "nothing that I know"
    if understood.ask_back is not None or understood.probability < READ:
        raise UsageError(
            f"The condition '{text}' was not surely understood; the likeliest reading, "
            f"{understood.probability:.0%}, is {words}: say it in other words, such as 'it has "
            f"turned 30 degrees clockwise' or 'it slips by more than 0.5 mm'."
        )
    if len(program.answers) != 1 or type_of(program.answers[0]) not in ("bool", "time"):
        raise UsageError(
            f"The condition '{text}' was read as {words}, expected something that holds or does "
            f"not, such as 'it has turned 30 degrees' or 'contact is lost'."
        )
    holds = _reached(program.answers[0])
    if type_of(holds) != "bool":
        raise UsageError(
            f"The condition '{text}' was read as {words}, a time; say what is to happen until then."
        )
    if is_negated:
        holds = holds.arguments[0] if holds.word == "not" else of("not", holds)
    frame = with_facts(frame, program.facts, 224)
    condition = Condition(text, holds, frame, understood.probability, "")
    _require_possible(condition)
    words = restated(Program((holds,), program.facts)).removeprefix("whether ")
    return replace(condition, restated=words)


def _reached(expression: Expression) -> Expression:
    """Return a condition by which an amount that is named is one that is to be reached.

    "It has turned 30 degrees" holds from 30 degrees on, not about there alone.
    """
    if expression.word in ("~", "="):
        measure, number = expression.arguments
        if measure_of(head_of(measure)).word in GOING:
            return of(">", measure, number)
    if expression.word == "first-time":
        return _reached(expression.arguments[0])
    if expression.word in ("and", "or", "not"):
        return of(expression.word, *map(_reached, expression.arguments))
    return expression


def _require_possible(condition: Condition) -> None:
    """Refuse what could not be told of any recording."""
    value = answer(condition.holds, Context((evidence_now(_SAMPLE, 25.0),), condition.frame))
    if isinstance(value, Unknown) and value.reason in NEEDS:
        why = replies()["missing"][value.reason]
        raise UsageError(f"The condition '{condition.text}' can never be told: {why}")


def evidence_now(track: Track, fps: float | None, own: Any = None) -> Evidence:
    """Return what verdicts rest on: a track up to now, and the sensor's own motion if it is known.

    Args:
        track: With two frames or more.
        fps: Frames per second of the stream.
        own: Times (n,) and the sensor's steps (n, 4), as of `with_own_motion`.
    """
    worlds = worlds_of_track(track, belief_of_track(track, _AT_REST))
    if own is not None:
        worlds = with_own_motion(worlds, *own)
    rows, columns = track.frame_size
    step_s = float(np.median(np.diff(track.times_s)))
    numbers = tuple(int(track.numbers[place]) for place in (0, -1))
    return Evidence(
        worlds,
        Recording(columns, rows, fps or 1 / step_s, numbers[1] + 1, numbers, step_s=step_s),
    )


_AT_REST = Belief(
    mean=Twist(),
    covariance=np.eye(4),
    ways={way: 0.0 for way in Motion},
    contact=0.0,
    radius_px=0.0,
    readable=dict.fromkeys(COMPONENTS, True),
)
"""What a track's belief is made from where the model has looked at no four frames."""


def _sample() -> Track:
    """Return a track in which something touches, turns, slides and is let go."""
    count, kinds = 60, {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}
    twists = np.zeros((count, 4))
    twists[20:30, 0], twists[35:40, 1] = 2.0, 3.0
    touched = (np.arange(count) >= 10) & (np.arange(count) <= 50)
    still = Event(EventKind.TOUCH, 10, 10, 0.4, 0.4, Twist(), Span(0.0, 0.0), 1.0)
    let_go = replace(still, kind=EventKind.RELEASE, begin=50, end=50, begin_s=2.0, end_s=2.0,
                     component=Component.PRESS, is_let_go=True)  # fmt: skip
    ends = {Component.TURN: (19, 29), Component.SLIDE: (34, 39)}
    moved = [
        replace(still, kind=kinds[part], begin=a, end=b, begin_s=a / 25, end_s=b / 25,
                twist=Twist(*map(float, twists[a : b + 1].sum(axis=0))), component=part,
                amount=Span(float(np.linalg.norm(twists[a : b + 1].sum(axis=0))), 0.5))
        for part, (a, b) in ends.items()
    ]  # fmt: skip
    return Track(
        numbers=np.arange(count),
        times_s=np.arange(count) / 25,
        contact=np.where(touched, 0.99, 0.01),
        strength_grey=np.where(touched, 9.0, 0.0),
        twists=twists,
        covariances=np.tile(1e-4 * np.eye(4), (count, 1, 1)),
        radius_px=np.where(touched, 30.0, 0.0),
        turn_shares=np.zeros(count),
        events=(still, *moved, let_go),
        frame_size=(224, 224),
    )


_SAMPLE = _sample()


class Monitor:
    """Watches frames for a condition: those that are pushed one by one, or those of a stream.

    Iterated, it yields the verdicts at which the condition begins to hold until the stream ends;
    leaving the loop closes it. What is pushed waits for nothing and starts no thread.

    Args:
        tracker: Of the stream, as of `Answerer.tracker`.
        condition: As of `Answerer.condition`.
        stream: As of `open_source`; None where frames are pushed.
        sure: Probability with which it has to hold.
        lasting_s: For how long.
        whose: Of the object in the world where the sensor's own motion is given, or of the contact.
        since: What the condition is about: all since watching began, since it last held, or since
            `begin`, before which nothing holds.
        fps: Frames per second of the stream; None takes them from the frames' times.
    """

    def __init__(
        self,
        tracker: Any,
        condition: Condition,
        stream: Any = None,
        *,
        sure: float = SURE,
        lasting_s: float = 0.0,
        whose: Whose = "object",
        since: Literal["start", "last", "begin"] = "start",
        fps: float | None = None,
    ) -> None:
        if not 0.5 <= sure < 1:
            raise UsageError(f"A probability of {sure:g} was wanted, expected 0.5 to below 1.")
        if not 0 <= lasting_s < 3600:
            raise UsageError(f"A time of {lasting_s:g} s was wanted, expected 0 to an hour.")
        self.tracker, self.condition, self.stream = tracker, condition, stream
        self._sure, self._lasting_s, self._whose = sure, lasting_s, whose
        self._fps = stream.fps if stream is not None and fps is None else fps
        self._since, self._since_s = since, np.inf if since == "begin" else -np.inf
        self._own: list[tuple[float, Twist]] = []
        self._is_own_known = True
        self._number, self._true_since_s, self.holds = -1, None, False

    def begin(self) -> None:
        """Let the condition be about what comes from the last frame on: the gripper has closed."""
        self._since_s = self._own[-1][0] if self._own else -np.inf
        self._true_since_s, self.holds = None, False

    def __iter__(self) -> Iterator[Verdict]:
        """Yield the verdicts at which the condition begins to hold."""
        with closing(iter(self.stream)) as frames:
            for frame in frames:
                verdict = self.push(frame.image, frame.time_s, number=frame.number)
                if verdict.is_new:
                    yield verdict

    def push(
        self,
        frame: Frames,
        time_s: float,
        own_motion: Twist | None = None,
        number: int | None = None,
    ) -> Verdict:
        """Take in the next frame and return whether the condition holds at it.

        Args:
            frame: uint8, (rows, columns, 3), RGB.
            time_s: When it was taken.
            own_motion: How the sensor moved since the frame before, as the camera's picture has it:
                degrees clockwise, pixels of the 224-pixel square right and down, mm inward. None
                where it is not known.
            number: Of the frame in its recording; None counts on.

        Raises:
            UnreadableClip: If it is of another size than the frames before.
        """
        started = time.perf_counter()
        number = self._number + 1 if number is None else number
        self.tracker.feed(frame, time_s, number)
        return self.judged(time_s, number, own_motion, started)

    def judged(
        self,
        time_s: float,
        number: int,
        own_motion: Twist | None = None,
        started: float | None = None,
    ) -> Verdict:
        """Return whether the condition holds at the frame that the tracker was fed last.

        Args:
            time_s: When it was taken.
            number: Its number.
            own_motion: As of `push`.
            started: When it came, by `time.perf_counter`; None for now.
        """
        started = time.perf_counter() if started is None else started
        self._number = number
        self._is_own_known &= own_motion is not None
        self._own.append((time_s, own_motion or Twist()))
        track = self._track()
        probability, worded_now = None, lambda: "Nothing can be told yet."
        if track is not None:
            context = Context((evidence_now(track, self._fps, self._own_motion),),
                              self.condition.frame)  # fmt: skip
            try:
                probability = chance_of(self.condition.holds, context)
            except Untold:
                probability = None
            worded_now = lambda: _worded(self.condition, context)  # noqa: E731
        was = self.holds
        self._settle(probability, time_s)
        is_new = self.holds and not was
        if is_new and self._since == "last":
            self._since_s = time_s
            self.holds = False
        return Verdict(
            time_s,
            self._number,
            probability,
            self.holds or is_new,
            is_new,
            self._own_motion is None,
            1e3 * (time.perf_counter() - started),
            worded_now,
        )

    @property
    def _own_motion(self) -> tuple[Any, Any] | None:
        if not self._is_own_known or self._whose == "contact":
            return None
        times, twists = zip(*self._own, strict=True)
        steps = [(t.turn_deg, t.right_px, t.down_px, t.inward_mm) for t in twists]
        return np.array(times), np.array(steps)

    def _track(self) -> Track | None:
        """Return what was seen since the condition is counted; None of too little."""
        if self._since_s == np.inf:
            return None
        track = self.tracker.now()
        if np.isfinite(self._since_s) and len(track) > 1:
            if (track.times_s >= self._since_s).sum() < 2:
                return None
            track = track.between(self._since_s, float(track.times_s[-1]), unit="s")
        return track if len(track) > 1 else None

    def _settle(self, probability: float | None, time_s: float) -> None:
        """Let the condition hold, or no more."""
        if probability is not None and probability >= self._sure:
            self._true_since_s = time_s if self._true_since_s is None else self._true_since_s
        elif probability is None or probability < UNSURE or not self.holds:
            self._true_since_s, self.holds = None, False
        if self._true_since_s is not None:
            self.holds |= time_s - self._true_since_s >= self._lasting_s - 1e-9


def _worded(condition: Condition, context: Context) -> str:
    value = answer(condition.holds, context)
    if isinstance(value, Unknown):
        return str(replies()["missing"].get(value.reason, replies()["missing"]["unsure"]))
    teller = Teller(context.evidence.recording, condition.frame)
    return worded([value], "sentence", teller, value.probability).text
