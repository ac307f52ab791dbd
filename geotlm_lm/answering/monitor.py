"""Conditions on a running camera: a question that is answered yes or no, evaluated at every frame.

A verdict rests on the frames up to its own and on nothing later. What it is of, unless asked
otherwise, is the time since watching began: "it has turned 30 degrees" holds from the moment on at
which it has.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import astuple, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.answering.understanding import READ, understand
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import Unsure, UsageError, check_question
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.answers import answer, chance_of
from geotlm_lm.query.evaluate import Context, Evidence, Untold, with_facts
from geotlm_lm.query.phrases import replies, restated
from geotlm_lm.query.program import (
    GOING,
    Expression,
    Program,
    head_of,
    measure_of,
    of,
    type_of,
    words_of,
)
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Recording, Unknown
from geotlm_lm.query.worlds import with_own_motion, worlds_of_track
from geotlm_lm.query.written import worded
from geotlm_lm.recordings.streams import open_source
from geotlm_lm.track.events import Event, EventKind, Span
from geotlm_lm.track.summed import belief_of_track
from geotlm_lm.track.track import Track
from geotlm_lm.track.tracker import Tracker

SURE, UNSURE = 0.95, 0.5
"""Probability from which on a condition holds, and below which it holds no more: between the two it
stays as it is, so that noise does not make it flicker."""

OF_DEPTH = frozenset({"press", "in", "out", "move", "still", "any", "pause"})
"""Words of programs that a press changes."""

LOOKS = 150
"""Moments at most at which a look back asks first whether a condition holds."""

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
        return not OF_DEPTH.isdisjoint(words_of(self.holds))


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
        raise Unsure(
            f"The condition '{text}' was not surely understood; the likeliest reading, "
            f"{understood.probability:.0%}, is {words}: say it in other words, such as 'it has "
            f"turned 30 degrees clockwise' or 'it slips by more than 0.5 mm'.",
            words.removeprefix("whether "),
        )
    if [each.word for each in program.answers] == ["cannot"]:
        why = replies()["untold"][program.answers[0].arguments[0]]
        raise UsageError(f"The condition '{text}' can never be told: {why}")
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


def evidence_now(
    track: Track, fps: float | None, own: NDArray[np.float64] | None = None
) -> Evidence:
    """Return what verdicts rest on: a track up to now, and the sensor's own motion if it is known.

    Args:
        track: With two frames or more.
        fps: Frames per second of the stream.
        own: When frames were taken, and the sensor's steps, (n, 1 + 4), as of `with_own_motion`.
    """
    worlds = worlds_of_track(track, belief_of_track(track, _AT_REST))
    if own is not None:
        worlds = with_own_motion(worlds, own[:, 0], own[:, 1:])
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
    """Return a track of a second in which something touches and turns, all of it."""
    count, step = 26, Twist(turn_deg=2.0)
    touch = Event(EventKind.TOUCH, 0, 0, 0.0, 0.0, Twist(), Span(0.0, 0.0), 1.0)
    turn = replace(touch, kind=EventKind.TURN, component=Component.TURN, end=25, end_s=1.0,
                   twist=Twist(turn_deg=50.0), amount=Span(50.0, 0.5))  # fmt: skip
    return Track(
        numbers=np.arange(count),
        times_s=np.arange(count) / 25,
        contact=np.ones(count),
        strength_grey=np.full(count, 9.0),
        twists=np.vstack([np.zeros(4), np.tile(astuple(step), (count - 1, 1))]),
        covariances=np.tile(1e-4 * np.eye(4), (count, 1, 1)),
        radius_px=np.full(count, 30.0),
        turn_shares=np.zeros(count),
        events=(touch, turn),
        frame_size=(224, 224),
    )


_SAMPLE = _sample()
"""By which it is known what a condition needs that no recording holds, such as a pixel's size."""


class Monitor:
    """Watches frames for a condition: those that are pushed one by one, or those of a stream.

    Iterated, it yields the verdicts at which the condition begins to hold until the stream ends;
    leaving the loop closes it. What is pushed waits for nothing and starts no thread.

    Args:
        tracker: Of the stream, as of `Answerer.tracker`.
        condition: As of `Answerer.condition`.
        source: A camera or a recording, as of `open_source`, which is opened once it is iterated;
            None where frames are pushed.
        sure: Probability with which it has to hold.
        lasting_s: For how long.
        whose: Of the object in the world where the sensor's own motion is given, or of the contact.
        since: What the condition is about: all since watching began, since it last held, or since
            `begin`, before which nothing holds.
        fps: Frames per second of the stream; None takes them from the frames' times.
    """

    def __init__(
        self,
        tracker: Tracker,
        condition: Condition,
        source: str | Path | None = None,
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
        self.tracker, self.condition = tracker, condition
        self._source, self._fps = source, fps
        self._sure, self._lasting_s, self._whose = sure, lasting_s, whose
        self._since, self._since_s = since, np.inf if since == "begin" else -np.inf
        self._own: list[tuple[float, ...]] | None = None if whose == "contact" else []
        self._number, self._true_since_s, self.holds = -1, None, False

    def begin(self) -> None:
        """Let the condition be about what comes from the last frame on: the gripper has closed."""
        self._since_s = self.tracker.time_s if self._number >= 0 else -np.inf
        self._true_since_s, self.holds = None, False

    def __iter__(self) -> Iterator[Verdict]:
        """Yield the verdicts at which the condition begins to hold.

        Raises:
            MissingDependency, Stalled, UnreadableClip, UsageError: As of `open_source`.
        """
        if self._source is None:
            raise UsageError("This monitor was given no source; push frames, or give one.")
        stream = open_source(str(self._source), fps=self._fps)
        self._fps = stream.fps
        with closing(iter(stream)) as frames:
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
                where it is not known: from that frame on, the first aside, all is relative.
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
        is_first, self._number = self._number < 0, number
        if own_motion is None and not is_first:  # from then on all is relative
            self._own = None
        elif self._own is not None:
            self._own.append((self.tracker.time_s, *astuple(own_motion or Twist())))
        track, was = self._track(), self.holds
        context = None if track is None else self._context(track)
        probability = None if context is None else self._chance(context)
        self._settle(probability, time_s)
        is_new = self.holds and not was
        if is_new and self._since == "last":  # once for each time: it has to end before it is new
            self._since_s = self.tracker.time_s
        return Verdict(
            time_s,
            self._number,
            probability,
            self.holds,
            is_new,
            self._own is None,
            1e3 * (time.perf_counter() - started),
            partial(_worded, self.condition, context),
        )

    def look_back(self) -> Verdict | None:
        """Return the verdict at the first frame so far at which it held; None where it never did.

        Each frame is judged by those up to it, as they are settled by now, relative to the sensor;
        how long it lasted is not asked.
        """
        started, track = time.perf_counter(), self.tracker.so_far
        looks = min(len(track) - 1, LOOKS)
        if looks < 1:
            return None

        def chance(last: int) -> tuple[Context, float]:
            begin_s, end_s = map(float, track.times_s[[0, last]])
            seen = evidence_now(track.between(begin_s, end_s, unit="s"), self._fps)
            context = Context((seen,), self.condition.frame)
            return context, self._chance(context) or 0.0

        before = 0
        for place in np.linspace(1, len(track) - 1, looks).astype(int).tolist():
            context, probability = chance(place)
            if probability >= self._sure:
                break
            before = place
        else:
            return None
        while place - before > 1:  # the first frame of these
            middle = (before + place) // 2
            at_middle = chance(middle)
            if at_middle[1] < self._sure:
                before = middle
            else:
                place, (context, probability) = middle, at_middle
        return Verdict(
            float(track.times_s[place]),
            int(track.numbers[place]),
            probability,
            holds=True,
            is_new=True,
            is_relative=True,
            latency_ms=1e3 * (time.perf_counter() - started),
            evidence=partial(_worded, self.condition, context),
        )

    def _context(self, track: Track) -> Context:
        own = None if self._own is None else np.array(self._own)
        return Context((evidence_now(track, self._fps, own),), self.condition.frame)

    def _chance(self, context: Context) -> float | None:
        try:
            return chance_of(self.condition.holds, context)
        except Untold:
            return None

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


def _worded(condition: Condition, context: Context | None) -> str:
    if context is None:
        return "Nothing can be told yet."
    value = answer(condition.holds, context)
    if isinstance(value, Unknown):
        return str(replies()["missing"].get(value.reason, replies()["missing"]["unsure"]))
    teller = Teller(context.evidence.recording, condition.frame)
    return worded([value], "sentence", teller, value.probability).text
