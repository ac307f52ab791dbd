"""The memory that all requests share: a request that finds it taken is refused, and may come again.

Counted is what is declared, before it is there: the frames a recording says it has, and the length
of a message. It is given back when what it was taken for is gone, however that came about.
"""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import GeoTLMError

from .limits import BUDGET_BYTES

TITLE = "Busy"
"""Of the mistake, where the toolkit tells one."""

STATUS = 429
"""Of HTTP, for a request that finds the memory taken."""

AGAIN_S = 5
"""Seconds after which it may come again."""

TAKEN = (
    "The server's memory is taken by others' recordings at the moment; try again in a few seconds."
)


class Busy(GeoTLMError):
    """Others take the memory that a request needs."""

    def __init__(self) -> None:
        super().__init__(TAKEN)


class Keeper(Protocol):
    """Keeps what it could do without."""

    def let_go(self) -> bool:
        """Let go of what was not used for longest; tell whether there was anything."""


class Share:
    """A part of the budget, until it is given back.

    Args:
        budget: Whose it is.
        size_bytes: That were taken.
    """

    def __init__(self, budget: Budget, size_bytes: int) -> None:
        self._budget, self._size = budget, size_bytes
        self.is_kept = False

    def grow(self, more_bytes: int) -> None:
        """Take more.

        Raises:
            Busy: If others take it.
        """
        self._budget.reserve(more_bytes)
        self._size += more_bytes

    def shrink(self, size_bytes: int) -> None:
        """Give back all but so much."""
        size, self._size = self._size, min(size_bytes, self._size)
        self._budget.give_back(size - self._size)

    def halve(self) -> None:
        """Give half of it back."""
        self.shrink(self._size // 2)

    def close(self) -> None:
        """Give it all back, once."""
        self.shrink(0)

    def keep_with(self, what: Any) -> None:
        """Give it back once something is no longer in memory."""
        self.is_kept = True
        weakref.finalize(what, self.close).atexit = False


class Budget:
    """Bytes that all requests share.

    Args:
        most_bytes: Of them all.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most, self._taken, self._lock = most_bytes, 0, Lock()
        self._keepers: weakref.WeakSet[Keeper] = weakref.WeakSet()

    @property
    def taken_bytes(self) -> int:
        """Bytes that are taken now."""
        return self._taken

    def may_let_go(self, keeper: Keeper) -> None:
        """Ask somebody to let go of what is kept once there is not enough."""
        self._keepers.add(keeper)

    def take(self, size_bytes: int) -> Share:
        """Take a share.

        Raises:
            Busy: If others take it, and nobody keeps anything that could be done without.
        """
        size_bytes = min(size_bytes, self._most)
        self.reserve(size_bytes)
        return Share(self, size_bytes)

    @contextmanager
    def held(self, size_bytes: int) -> Iterator[Share]:
        """Take a share for the time of a block, unless it is kept with something.

        Raises:
            Busy: As of `take`.
        """
        share = self.take(size_bytes)
        try:
            yield share
        finally:
            if not share.is_kept:
                share.close()

    def read(self, declared_bytes: int, read: Callable[[], Any]) -> Any:
        """Return a recording, which holds its share for as long as its frames are in memory.

        Args:
            declared_bytes: Of its frames; while they are read they may be there twice.
            read: Reads it.

        Raises:
            Busy: As of `take`.
        """
        with self.held(2 * declared_bytes) as share:
            clip = read()
            share.shrink(clip.frames.nbytes)
            share.keep_with(_owner(clip.frames))
        return clip

    def reserve(self, size_bytes: int) -> None:
        """Take so many bytes; as `take` in all else."""
        while not self._is_reserved(size_bytes):
            if not any(keeper.let_go() for keeper in list(self._keepers)):
                gc.collect()  # what is only held by itself is no longer needed
                if self._is_reserved(size_bytes):
                    return
                raise Busy

    def _is_reserved(self, size_bytes: int) -> bool:
        with self._lock:
            is_enough = self._taken + size_bytes <= self._most
            self._taken += size_bytes if is_enough else 0
            return is_enough

    def give_back(self, size_bytes: int) -> None:
        """Give so many bytes back."""
        with self._lock:
            self._taken -= size_bytes


def _owner(frames: NDArray[np.uint8]) -> Any:
    """Return what holds the memory that an array is a view of."""
    while isinstance(frames.base, np.ndarray):
        frames = frames.base
    return frames


WORKING = Budget(BUDGET_BYTES)
"""Of this process: however many pages it serves, it has one memory."""

MESSAGE: ContextVar[Share | None] = ContextVar("message", default=None)
"""What the message takes that is being read."""


def keep_messages_counted(queue: Any) -> None:
    """Have a message that waits in a toolkit's queue take its share until it was worked on.

    Args:
        queue: The page's own.
    """
    pushed, processed = queue.push, queue.process_events
    shares: weakref.WeakKeyDictionary[Any, Share] = weakref.WeakKeyDictionary()

    async def push(*given: Any, **named: Any) -> Any:
        told = await pushed(*given, **named)
        share, event = MESSAGE.get(), queue.event_ids_to_events.get(told[1])
        if share is not None and event is not None:
            share.halve()  # what is left of it is its text, and what that unpacks to
            share.keep_with(event)  # one that is taken out of the line is gone at once
            shares[event] = share
        return told

    async def process_events(events: list[Any], *given: Any, **named: Any) -> None:
        try:
            await processed(events, *given, **named)
        finally:  # the toolkit holds the last one for as long as no other comes
            for event in events:
                if (share := shares.pop(event, None)) is not None:
                    share.close()

    queue.push, queue.process_events = push, process_events
