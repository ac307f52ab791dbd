"""Refuses a message that is longer than any tool takes, before it is held in memory."""

from __future__ import annotations

from .limits import MESSAGE_BYTES, MIB
from .own_names import App, Message, Receive, Send, refuse

UPLOAD_ROUTE = "/upload"
"""End of the address that recordings are sent to, which has a limit of its own."""

REFUSED = f"A message may be {MESSAGE_BYTES // MIB} MiB long; upload the recording instead."


class MessageLimit:
    """Passes on what is short enough.

    Args:
        app: That is called for it (ASGI).
        most_bytes: Of a message.
    """

    def __init__(self, app: App, most_bytes: int = MESSAGE_BYTES) -> None:
        self._app, self._most = app, most_bytes

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 413; one that grows too long is cut off."""
        if scope["type"] != "http" or scope["path"].rstrip("/").endswith(UPLOAD_ROUTE):
            await self._app(scope, receive, send)
            return
        declared = [value for name, value in scope["headers"] if name == b"content-length"]
        if any(not one.isdigit() or int(one) > self._most for one in declared):
            await refuse(send, 413, REFUSED)
            return
        await self._app(scope, self._counted(receive), send)

    def _counted(self, receive: Receive) -> Receive:
        length = 0

        async def counted() -> Message:
            nonlocal length
            message = await receive()
            length += len(message.get("body", b""))
            return {"type": "http.disconnect"} if length > self._most else message

        return counted
