"""What the server refuses: other sites, addresses, messages that are too long, work beyond memory.

Every limit is stated here. `Guard` stands before the page (ASGI). `Budget` counts the memory that
all requests share: what is declared before it is there, the frames that a recording says it has and
the length of a message. It is given back when what it was taken for is gone, for whatever reason.
"""

from __future__ import annotations

import gc
import re
import weakref
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

import geotlm_lm as lm

MIB = 2**20

UPLOAD_BYTES = 512 * MIB
"""Of a recording that is uploaded, or lies in the folder that is served."""

INLINE_BYTES = 64 * MIB
"""Of a recording inside a message; it is held in memory several times on its way."""

MESSAGE_BYTES = 2 * (INLINE_BYTES * 4 // 3) + MIB
"""Of a message to a tool: two recordings in base64, for a comparison, and a question."""

QUESTION_CHARACTERS = 2000
"""Of a question: the reader takes no more."""

NAME_CHARACTERS, TOPIC_CHARACTERS = 400, 200
"""Of a recording's name, and of the name of a bag's topic."""

LISTED = 1000
"""Recordings of the folder that are listed."""

EVENTS, ROWS = 200, 500
"""Events and frames of a track that a tool returns at most."""

AT_ONCE, QUEUE = 24, 64
"""Requests that are worked on at once, taking turns at the model, and that may wait beside them."""

BUDGET_BYTES = 2048 * MIB
"""Of all recordings and messages that are in memory at once: those that are worked on, those that
visitors have open, and those that stay open; what is only kept goes first."""

KEPT_OPEN_BYTES, KEPT_OPEN_S = 512 * MIB, 600.0
"""Of recordings that stay open for a tool's next question, and for how long after the last one."""

SENTENCE = (
    f"A question may be {QUESTION_CHARACTERS} characters long, an upload "
    f"{UPLOAD_BYTES // MIB} MiB, a recording inside a message {INLINE_BYTES // MIB} MiB; "
    f"of a recording as many frames are read as fit {UPLOAD_BYTES // MIB} MiB (2,300 of 320 x 240 "
    f"pixels), evenly spread if it has more; a tool tells {EVENTS} events and {ROWS} frames at "
    f"most; {AT_ONCE} requests are worked on at once and {QUEUE} wait, as far as their recordings "
    f"fit into {BUDGET_BYTES // MIB} MiB together; one more is refused (HTTP status 429)."
)
"""The limits as agents and the documentation state them."""

BUSY_STATUS, BUSY_TITLE, AGAIN_S = 429, "Busy", 5
"""Of a request that finds the memory taken: HTTP status, title of the toolkit's error, and seconds
after which it may come again."""

TAKEN = (
    "The server's memory is taken by others' recordings at the moment; try again in a few seconds."
)


class Busy(lm.GeoTLMError):
    """Others take the memory that a request needs."""

    def __init__(self) -> None:
        super().__init__(TAKEN)


class Share:
    """A part of the budget until it is given back; `is_kept` once something else gives it back."""

    def __init__(self, budget: Budget, size_bytes: int) -> None:
        self._budget, self.size_bytes, self.is_kept = budget, size_bytes, False

    def resize(self, size_bytes: int) -> None:
        """Give back what is beyond a size."""
        size_before, self.size_bytes = self.size_bytes, size_bytes
        self._budget.give_back(size_before - size_bytes)

    def keep_with(self, owner: Any) -> None:
        """Give all of it back once the owner is no longer in memory."""
        self.is_kept = True
        weakref.finalize(owner, self.resize, 0).atexit = False


class Budget:
    """Bytes that all requests share, `most_bytes` of them."""

    def __init__(self, most_bytes: int) -> None:
        self._most, self.taken_bytes, self._lock = most_bytes, 0, Lock()
        self._keepers: weakref.WeakSet[Any] = weakref.WeakSet()

    def may_let_go(self, keeper: Any) -> None:
        """Ask a keeper, once there is not enough, to let go of what was not used for longest.

        Its `let_go` returns whether there was anything.
        """
        self._keepers.add(keeper)

    def take(self, size_bytes: int) -> Share:
        """Take a share; of more than there is, all.

        Raises:
            Busy: If others take it, and no keeper has anything left to let go of.
        """
        size_bytes = min(size_bytes, self._most)
        while not self._is_reserved(size_bytes):
            if not any(keeper.let_go() for keeper in list(self._keepers)):
                gc.collect()  # what is only held by itself is no longer needed
                if not self._is_reserved(size_bytes):
                    raise Busy
                break
        return Share(self, size_bytes)

    @contextmanager
    def held(self, size_bytes: int) -> Iterator[Share]:
        """Take a share for the time of a block, unless it is kept with something."""
        share = self.take(size_bytes)
        try:
            yield share
        finally:
            if not share.is_kept:
                share.resize(0)

    def read(self, declared_bytes: int, read: Callable[[], Any]) -> Any:
        """Return a clip, which holds its share for as long as its frames are in memory.

        While they are read the frames may be there twice.
        """
        with self.held(2 * declared_bytes) as share:
            clip = read()
            share.resize(min(share.size_bytes, clip.frames.nbytes))
            share.keep_with(_owner(clip.frames))
        return clip

    def _is_reserved(self, size_bytes: int) -> bool:
        with self._lock:
            is_enough = self.taken_bytes + size_bytes <= self._most
            self.taken_bytes += size_bytes if is_enough else 0
            return is_enough

    def give_back(self, size_bytes: int) -> None:
        """Count so many bytes as free again."""
        with self._lock:
            self.taken_bytes -= size_bytes


def _owner(frames: NDArray[np.uint8]) -> Any:
    """Return what holds the memory that an array is a view of."""
    while isinstance(frames.base, np.ndarray):
        frames = frames.base
    return frames


MEMORY = Budget(BUDGET_BYTES)
"""Of this process: however many pages it serves, it has one memory."""

MESSAGE: ContextVar[Share | None] = ContextVar("message", default=None)
"""Share of the message that is being read."""


def keep_messages_counted(queue: Any) -> None:
    """Let a message that waits in the toolkit's queue hold its share until it was worked on."""
    push, process_events = queue.push, queue.process_events
    shares: weakref.WeakKeyDictionary[Any, Share] = weakref.WeakKeyDictionary()

    async def counted_push(*given: Any, **named: Any) -> Any:
        result = await push(*given, **named)
        share, event = MESSAGE.get(), queue.event_ids_to_events.get(result[1])
        if share is not None and event is not None:
            share.resize(share.size_bytes // 2)  # its text is left, and what that unpacks to
            share.keep_with(event)  # one that is taken out of the line is gone at once
            shares[event] = share
        return result

    async def counted_process(events: list[Any], *given: Any, **named: Any) -> None:
        try:
            await process_events(events, *given, **named)
        finally:  # the toolkit holds the last event for as long as no other comes
            for event in events:
                if (share := shares.pop(event, None)) is not None:
                    share.resize(0)

    queue.push, queue.process_events = counted_push, counted_process


Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]

OWN_NAMES = ("127.0.0.1", "::1", "localhost")
"""Of this machine, as it calls itself."""

NOT_OURS = (
    f"This page answers to {', '.join(OWN_NAMES)} only, and to no page of another site; open it by "
    "the address that was printed when it was started."
)
NO_ADDRESSES = "Files are not fetched from an address; upload the file itself."
NO_LENGTH = "A message has to declare its length; send it whole, with the header Content-Length."
TOO_LONG = f"A message may be {MESSAGE_BYTES // MIB} MiB long; upload the recording instead."

FETCHED = ("/file=http:", "/file=https:", "/proxy=")
"""Parts of the addresses at which the toolkit passes on what it fetches from elsewhere."""

UPLOAD_ROUTE = "/upload"
"""End of the address that recordings are sent to, which has a limit of its own."""

CALLS = ("/call/", "/run/")
"""Parts of the addresses at which tools are called."""

COPIES, SHORT_BYTES = 4, MIB // 16
"""Times that a message is in memory on its way (bytes, text, parts, unpacked), and the length up to
which it is not counted."""

BUSY = re.compile(rb'"title": ?"%b"' % BUSY_TITLE.encode())
"""Part of the toolkit's answer to who is refused; in a text the quotes would be escaped."""


class Guard:
    """Answers 403, 411, 413 or 429 itself, before anything is read, and passes the rest on (ASGI).

    A site whose name is made to mean this machine (DNS rebinding) would be taken by the browser for
    the page itself: a request must name one of `OWN_NAMES` as its host, and as its origin that host
    or none. The toolkit would fetch an address for whoever asks: none is passed on.
    """

    def __init__(self, app: App, most_bytes: int = MESSAGE_BYTES) -> None:
        self._app, self._most = app, most_bytes

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on; a websocket of another site is closed."""
        kind, path = scope["type"], scope.get("path", "")
        if kind not in ("http", "websocket"):
            await self._app(scope, receive, send)
        elif not _is_own(scope["headers"]):
            if kind == "websocket":
                await send({"type": "websocket.close", "code": 1008})
            else:
                await _refuse(send, 403, NOT_OURS)
        elif any(part in path.lower() for part in FETCHED):
            await _refuse(send, 403, NO_ADDRESSES)
        elif kind == "websocket" or path.rstrip("/").endswith(UPLOAD_ROUTE):
            await self._app(scope, receive, send)
        else:
            await self._limit(scope, receive, send)

    async def _limit(self, scope: Message, receive: Receive, send: Send) -> None:
        if any(name == b"transfer-encoding" for name, _ in scope["headers"]):
            await _refuse(send, 411, NO_LENGTH)
            return
        lengths = [value for name, value in scope["headers"] if name == b"content-length"]
        if any(not value.isdigit() or int(value) > self._most for value in lengths):
            await _refuse(send, 413, TOO_LONG)
            return
        length = max(map(int, lengths), default=0)
        is_call = any(part in scope["path"] for part in CALLS)
        try:
            with MEMORY.held(COPIES * length if length > SHORT_BYTES else 0) as share:
                MESSAGE.set(share)
                await self._app(scope, receive, _with_busy_status(send) if is_call else send)
        except Busy:
            await _refuse(send, BUSY_STATUS, TAKEN, (b"retry-after", str(AGAIN_S).encode()))


def _is_own(headers: list[tuple[bytes, bytes]]) -> bool:
    hosts = [f"http://{value.decode('latin-1')}" for name, value in headers if name == b"host"]
    origins = [value.decode("latin-1") for name, value in headers if name == b"origin"]
    if len(hosts) != 1:
        return False
    host = place_of(hosts[0])
    # The port it was asked for is not always the one it listens on: it may be forwarded.
    return host[0] in OWN_NAMES and all(place_of(origin) == host for origin in origins)


def place_of(address: str) -> tuple[str | None, int | None]:
    """Return the host name and the port of an address; the scheme's usual port is None."""
    try:
        parts = urlsplit(address)
        port = parts.port
    except ValueError:  # brackets that are not closed, a port that is no number
        return None, None
    return parts.hostname, None if port == {"http": 80, "https": 443}.get(parts.scheme) else port


async def _refuse(send: Send, status: int, sentence: str, *more: tuple[bytes, bytes]) -> None:
    """Answer a request whose body was not read: none can follow on the same connection."""
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close"), *more]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": f"{sentence}\n".encode()})


def _with_busy_status(send: Send) -> Send:
    """Return a `send` that answers 429 where the first part of a tool's answer says `Busy`.

    What a call needs is known only while it is worked on, when the toolkit has already begun to
    answer; so the beginning waits for the first part. Agents get the sentence and the status as a
    tool's error: their protocol's client takes another HTTP status for the server's end.
    """
    begun: Message | None = None

    async def send_held(message: Message) -> None:
        nonlocal begun
        if message["type"] == "http.response.start":
            begun = message
            return
        if begun is not None:
            start, begun = begun, None
            if BUSY.search(message.get("body", b"")):
                again = (b"retry-after", str(AGAIN_S).encode())
                start = {**start, "status": BUSY_STATUS, "headers": [*start["headers"], again]}
            await send(start)
        await send(message)

    return send_held


def refuse_addresses(page: Any) -> None:
    """Let no input of a page (a `gradio.Blocks`) take a file by its address."""
    preprocess = page.preprocess_data

    async def checked(function: Any, inputs: list[Any], *rest: Any, **named: Any) -> Any:
        if any("://" in path for path in _paths_in(inputs)):
            import gradio as gr

            raise gr.Error(NO_ADDRESSES, print_exception=False)
        return await preprocess(function, inputs, *rest, **named)

    page.preprocess_data = checked


def _paths_in(value: Any) -> Iterator[str]:
    """Yield the path of every file in what a page was sent."""
    if isinstance(value, dict):
        if isinstance(value.get("path"), str):
            yield value["path"]
        value = list(value.values())
    if isinstance(value, list | tuple):
        for part in value:
            yield from _paths_in(part)
