"""Refuses a message that is longer than any tool takes, or than there is memory for, unread."""

from __future__ import annotations

from contextlib import suppress

from .budget import AGAIN_S, MESSAGE, STATUS, TAKEN, WORKING, Busy, Share
from .limits import MESSAGE_BYTES, MIB
from .own_names import App, Message, Receive, Send, refuse

UPLOAD_ROUTE = "/upload"
"""End of the address that recordings are sent to, which has a limit of its own."""

REFUSED = f"A message may be {MESSAGE_BYTES // MIB} MiB long; upload the recording instead."

COPIES = 4
"""Times that a message is in memory on its way: as bytes, as text, in parts, and unpacked."""

SHORT_BYTES = MIB // 16
"""Of a message that is not counted."""


class MessageLimit:
    """Passes on what is short enough, and what there is memory for.

    Args:
        app: That is called for it (ASGI).
        most_bytes: Of a message.
    """

    def __init__(self, app: App, most_bytes: int = MESSAGE_BYTES) -> None:
        self._app, self._most = app, most_bytes

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 413 or 429; one that grows too long is cut off."""
        if scope["type"] != "http" or scope["path"].rstrip("/").endswith(UPLOAD_ROUTE):
            await self._app(scope, receive, send)
            return
        declared = [value for name, value in scope["headers"] if name == b"content-length"]
        if any(not one.isdigit() or int(one) > self._most for one in declared):
            await refuse(send, 413, REFUSED)
            return
        length = max(map(int, declared), default=0)
        try:
            with WORKING.held(COPIES * length if length > SHORT_BYTES else 0) as share:
                MESSAGE.set(share)
                await _Passing(self._app, share, length, self._most).call(scope, receive, send)
        except Busy:
            await refuse(send, STATUS, TAKEN, (b"retry-after", str(AGAIN_S).encode()))


class _Passing:
    """A message on its way; one that did not tell its length takes its share as it comes."""

    def __init__(self, app: App, share: Share, counted: int, most: int) -> None:
        self._app, self._share, self._counted, self._most = app, share, counted, most
        self._length, self._is_busy, self._has_begun = 0, False, False

    async def call(self, scope: Message, receive: Receive, send: Send) -> None:
        async def received() -> Message:
            message = await receive()
            self._length += len(message.get("body", b""))
            if self._length > self._most or not self._is_counted():
                return {"type": "http.disconnect"}
            return message

        async def sent(message: Message) -> None:
            self._has_begun = True
            if not self._is_busy:
                await send(message)

        await self._app(scope, received, sent)
        if self._is_busy and not self._has_begun:
            raise Busy

    def _is_counted(self) -> bool:
        more = max(self._length, SHORT_BYTES) - max(self._counted, SHORT_BYTES)
        if more > 0 and not self._is_busy:
            self._is_busy = True
            with suppress(Busy):
                self._share.grow(COPIES * more)
                self._counted, self._is_busy = self._length, False
        return not self._is_busy
