"""Turns at the model, which everybody shares: requests wait in line, long work lets others in.

A recording is tracked frame by frame; once its slice of time is over it stands in line again if
others wait. So a question waits for a slice of each recording, never for a whole; slices are the
shorter the more stand in line.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from contextvars import ContextVar
from queue import SimpleQueue
from threading import Condition, Event, Lock, Thread
from typing import Any

import geotlm_lm as lm

SLICE_S = 0.4
"""Time after which a turn is over if one other waits; of more each waits for its share of this."""

REPORTED_EVERY_S = 0.25
"""Time between two reports of progress."""

Report = Callable[[str, int, int], Any]
"""Takes what is done, how much of it, and of how much, and shows this to who waits."""

LISTENER: ContextVar[Report | None] = ContextVar("listener", default=None)
"""Takes the progress of a request in place of the page, where a client wants to know it."""


class Turns:
    """A lock that is handed on in the order in which it was asked for."""

    def __init__(self, report: Report = lambda *_: None, slice_s: float = SLICE_S) -> None:
        self.report, self.slice_s = report, slice_s
        self._line: list[Turn] = []  # the first one holds the lock
        self._changed = Condition()

    @contextmanager
    def turn(self) -> Iterator[Turn]:
        """Wait for a turn, and hold it."""
        turn = Turn(self)
        try:
            self.enter(turn)
            yield turn
        finally:
            self.leave(turn)

    @property
    def waiting(self) -> int:
        """How many stand in line."""
        return max(len(self._line) - 1, 0)

    def enter(self, turn: Turn) -> None:
        """Stand in line, and wait until this is the first."""
        with self._changed:
            self._line.append(turn)
        while before := self._before(turn):
            self.report(f"waiting for the model, {before} before you", 0, before)

    def _before(self, turn: Turn) -> int:
        """Wait for a while, and return how many are still before a turn."""
        with self._changed:
            self._changed.wait_for(lambda: self._line[0] is turn, REPORTED_EVERY_S)
            return self._line.index(turn)

    def leave(self, turn: Turn) -> None:
        """Stand in line no more; no other can slip in before the next."""
        with self._changed:
            if turn in self._line:
                self._line.remove(turn)
            self._changed.notify_all()


class Turn:
    """A turn, given up for a while between two frames."""

    def __init__(self, turns: Turns) -> None:
        self._turns = turns
        self._since_s = self._reported_s = time.monotonic()

    def progress(self, what: str, done: int, total: int) -> None:
        """Report how far it is, and let those who wait go first once the slice is over."""
        now_s = time.monotonic()
        if now_s - self._reported_s >= REPORTED_EVERY_S:
            self._reported_s = now_s
            self._turns.report(what, done, total)
        waiting = self._turns.waiting
        if waiting and now_s - self._since_s >= self._turns.slice_s / waiting:
            self._turns.leave(self)
            self._turns.enter(self)
            self._since_s = time.monotonic()


class Stopped(lm.GeoTLMError):
    """What was begun is wanted no more."""


def reported(work: Callable[[], Any], show: Report) -> Iterator[Any]:
    """Yield what shows how far something is that uses the model, and return its result.

    It is stopped at its next report once nobody takes any more of this.
    """
    reports: SimpleQueue[Any] = SimpleQueue()
    is_closed, done = Event(), Future[Any]()

    def listen(*report: Any) -> None:
        if is_closed.is_set():
            raise Stopped("This was stopped.")
        reports.put(report)

    def run() -> None:
        LISTENER.set(listen)
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)
        reports.put(None)

    Thread(target=run, daemon=True).start()
    try:
        while (report := reports.get()) is not None:
            yield show(*report)
    finally:
        is_closed.set()
    return done.result()


class _InTurns:
    """Stands for something that uses the model: the methods named here wait for their turn.

    Of these the `sharing` ones report how far they are, and let others in meanwhile.
    """

    waiting: tuple[str, ...] = ()
    sharing: tuple[str, ...] = ()

    def __init__(self, shared: Any, turns: Turns) -> None:
        self._shared, self._turns = shared, turns

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            super().__setattr__(name, value)
        else:
            setattr(self._shared, name, value)

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._shared, name)
        if name not in self.waiting:
            return value

        def call(*given: Any, **named: Any) -> Any:
            with self._turns.turn() as turn:
                if name in self.sharing:
                    named["progress"] = turn.progress
                return value(*given, **named)

        return call


class AnswererInTurns(_InTurns):
    """An `Answerer` that waits for its turn; tracking lets others in between two frames."""

    sharing = ("encode", "track")
    waiting = ("ask", "compare", "condition", *sharing)

    def tracker(self, recording: Any = None) -> TrackerInTurns:
        """As `Answerer.tracker`; each frame waits for its turn."""
        with self._turns.turn():
            return TrackerInTurns(self._shared.tracker(recording), self._turns)

    def session(self, encoded: Any, **named: Any) -> SessionInTurns:
        """As `Answerer.session`."""
        return SessionInTurns(self._shared.session(encoded, **named), self._turns)


class SessionInTurns(_InTurns):
    """A `Session` each of whose questions waits for its turn, and can be stopped."""

    _asking: object = None

    def ask(self, question: str) -> Any:
        """As `Session.ask`; a question that is stopped meanwhile leaves no trace."""
        asking = self._asking = object()
        with self._turns.turn():
            answer = None if self._asking is not asking else self._shared.ask(question)
            if self._asking is asking:
                return answer
            if answer is not None:
                self._shared.take_back(question)
        raise Stopped("The question was stopped.")

    def stop(self) -> None:
        """Let the question that is being answered be forgotten."""
        self._asking = None


class TrackerInTurns(_InTurns):
    """A `Tracker` each of whose frames waits for its turn."""

    waiting = ("feed", "finish", "now")

    @property
    def so_far(self) -> Any:
        """The track as far as it is settled, not amid a frame."""
        with self._turns.turn():
            return self._shared.so_far


class LazyAnswerer:
    """Becomes an `Answerer` at its first use, so that the page stands before it is loaded."""

    def __init__(self, load: Callable[[], lm.Answerer]) -> None:
        self._load, self._lock = load, Lock()
        self._loaded: lm.Answerer | None = None

    def load(self) -> lm.Answerer:
        """Return the model; other threads wait while one loads it; an error is tried again."""
        with self._lock:
            if self._loaded is None:
                self._loaded = self._load()
            return self._loaded

    def __getattr__(self, name: str) -> Any:
        return getattr(self.load(), name)
