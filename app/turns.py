"""Turns at the model: whoever wants it waits in line, and long work lets others in between.

A recording is tracked frame by frame; after a tenth of a second its turn is over if anybody waits,
and it stands in line again. So nobody waits for a whole recording, only for a slice of each.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event, Lock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geotlm_lm import Answerer, FrameSpec, Session, Tracker

SLICE_S = 0.1
"""Time after which a turn is over if others wait: some ten frames of a recording."""

TOLD_EVERY_S = 0.25
"""Time between two words of how far it is."""

Tell = Callable[[str, int, int], None]
"""Called with what is done, how much of it, and of how much; it shows this to whoever waits."""


LISTENER: ContextVar[Tell | None] = ContextVar("listener", default=None)
"""Is told how far a request is in place of the page, where one from elsewhere wants to know."""


def silent(what: str, done: int, total: int) -> None:
    """Show nothing."""


class Turns:
    """A lock that is handed on in the order in which it was asked for.

    Args:
        tell: Shows the place in the line, and how far long work is.
        slice_s: Time after which long work gives it up to those who wait.
    """

    def __init__(self, tell: Tell = silent, slice_s: float = SLICE_S) -> None:
        self.tell, self.slice_s = tell, slice_s
        self._lock = Lock()
        self._line: deque[Event] = deque()
        self._is_taken = False

    @contextmanager
    def turn(self) -> Iterator[Turn]:
        """Wait for a turn, and hold it."""
        self.take()
        turn = Turn(self)
        try:
            yield turn
        finally:
            if turn.is_held:
                self.give()

    @property
    def waiting(self) -> int:
        """How many stand in line."""
        return len(self._line)

    def take(self) -> None:
        """Wait until it is this thread's turn."""
        mine = Event()
        with self._lock:
            if not self._is_taken:
                self._is_taken = True
                return
            self._line.append(mine)
        try:
            self._wait(mine)
        except BaseException:
            self._leave(mine)
            raise

    def give(self) -> None:
        """Hand the turn to the first in line; nobody can slip in between."""
        with self._lock:
            if self._line:
                self._line.popleft().set()
            else:
                self._is_taken = False

    def _wait(self, mine: Event) -> None:
        while not mine.wait(TOLD_EVERY_S):
            with self._lock:
                before = self._line.index(mine) + 1 if mine in self._line else 0
            if before:
                self.tell(f"waiting for the model, {before} before you", 0, before)

    def _leave(self, mine: Event) -> None:
        """Stand in line no more; a turn that came in the meantime goes to the next."""
        with self._lock:
            if is_waiting := mine in self._line:
                self._line.remove(mine)
        if not is_waiting:
            self.give()


class Turn:
    """A turn that is held, and may be given up for a while between two frames.

    Args:
        turns: Whose it is.

    Attributes:
        is_held: Whether it is held now; not while others go first, nor if the wait for them failed.
    """

    def __init__(self, turns: Turns) -> None:
        self._turns = turns
        self.is_held = True
        self._since_s = self._told_s = time.monotonic()

    def progress(self, what: str, done: int, total: int) -> None:
        """Tell how far it is, and let those who wait go first once the slice is over."""
        now_s = time.monotonic()
        if now_s - self._told_s >= TOLD_EVERY_S:
            self._told_s = now_s
            self._turns.tell(what, done, total)
        if self._turns.waiting and now_s - self._since_s >= self._turns.slice_s:
            self.is_held = False
            self._turns.give()
            self._turns.take()
            self.is_held = True
            self._since_s = time.monotonic()


class AnswererInTurns:
    """An `Answerer` that everybody shares: whatever uses the model waits for its turn.

    Args:
        answerer: The model.
        turns: At it.
    """

    def __init__(self, answerer: Answerer, turns: Turns) -> None:
        self._answerer, self._turns = answerer, turns

    def encode(self, clip: Any, **named: Any) -> Any:
        """Perceive or track a recording, letting others in between; as `Answerer.encode`."""
        with self._turns.turn() as turn:
            return self._answerer.encode(clip, progress=turn.progress, **named)

    def track(self, recording: Any) -> Any:
        """Track a recording, letting others in between; as `Answerer.track`."""
        with self._turns.turn() as turn:
            return self._answerer.track(recording, progress=turn.progress)

    def tracker(self, recording: Any = None) -> TrackerInTurns:
        """Return what follows frames one by one, each in a turn; as `Answerer.tracker`."""
        with self._turns.turn():
            return TrackerInTurns(self._answerer.tracker(recording), self._turns)

    def ask(self, encoded: Any, question: str, **named: Any) -> Any:
        """Answer a question; as `Answerer.ask`."""
        with self._turns.turn():
            return self._answerer.ask(encoded, question, **named)

    def compare(self, first: Any, second: Any, *question: str, **named: Any) -> Any:
        """Answer a question about two recordings; as `Answerer.compare`."""
        with self._turns.turn():
            return self._answerer.compare(first, second, *question, **named)

    def session(self, encoded: Any, **named: Any) -> SessionInTurns:
        """Return a conversation, each of whose questions waits for its turn."""
        return SessionInTurns(self._answerer.session(encoded, **named), self._turns)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._answerer, name)


class SessionInTurns:
    """A conversation each of whose questions waits for its turn; in all else a `Session`.

    Args:
        session: The conversation.
        turns: At the model.
    """

    def __init__(self, session: Session, turns: Turns) -> None:
        self._session, self._turns = session, turns

    @property
    def frame(self) -> FrameSpec:
        """The frame of reference that holds now."""
        return self._session.frame

    @frame.setter
    def frame(self, frame: FrameSpec) -> None:
        self._session.frame = frame

    def ask(self, question: str) -> Any:
        """Answer the next question; as `Session.ask`."""
        with self._turns.turn():
            return self._session.ask(question)

    def stream(self, question: str) -> Iterator[Any]:
        """Yield the reply word by word, each found in a turn; as `Session.stream`."""
        pieces, is_over = self._session.stream(question), object()
        while True:
            with self._turns.turn():
                piece = next(pieces, is_over)
            if piece is is_over:
                return
            yield piece

    def __getattr__(self, name: str) -> Any:
        return getattr(self._session, name)


class TrackerInTurns:
    """A `Tracker` each of whose frames waits for its turn.

    Args:
        tracker: That is fed.
        turns: At the model.
    """

    def __init__(self, tracker: Tracker, turns: Turns) -> None:
        self._tracker, self._turns = tracker, turns

    def feed(self, *given: Any) -> Any:
        """Take in the next frame; as `Tracker.feed`."""
        with self._turns.turn():
            return self._tracker.feed(*given)

    def finish(self) -> Any:
        """Return the track of all frames; as `Tracker.finish`."""
        with self._turns.turn():
            return self._tracker.finish()

    @property
    def so_far(self) -> Any:
        """The track as far as it is settled; as `Tracker.so_far`, and not amid a frame."""
        with self._turns.turn():
            return self._tracker.so_far

    def __getattr__(self, name: str) -> Any:
        return getattr(self._tracker, name)
