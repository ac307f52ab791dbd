"""A request over REST that found the memory taken is answered by HTTP status 429.

What it needs is known only while it is worked on, when the toolkit has already begun to answer; so
the beginning of an answer waits for the first of what is answered. Agents get the same sentence and
status as a tool's mistake: their protocol's client takes another HTTP status for the server's end.
"""

from __future__ import annotations

import json
from typing import Any

from .budget import AGAIN_S, STATUS, TITLE
from .own_names import App, Message, Receive, Send

CALLS = ("/call/", "/run/")
"""Parts of the addresses at which tools are called."""

LONGEST_BYTES = 4096
"""Of what tells a mistake."""


class BusyStatus:
    """Gives the status to answers that say so.

    Args:
        app: That answers (ASGI).
    """

    def __init__(self, app: App) -> None:
        self._app = app

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on; what is answered to a tool's call waits for its first part."""
        is_call = scope["type"] == "http" and any(part in scope["path"] for part in CALLS)
        if not is_call:
            await self._app(scope, receive, send)
            return
        begun: Message | None = None

        async def held(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = message
                return
            if begun is not None:
                start, begun = begun, None
                await send(_as_busy(start) if is_busy(message.get("body", b"")) else start)
            await send(message)

        await self._app(scope, receive, held)


def is_busy(body: bytes) -> bool:
    """Tell whether the first of an answer says that the memory is taken."""
    if len(body) > LONGEST_BYTES:
        return False
    lines = body.decode(errors="replace").splitlines()
    stored = [line.removeprefix("data:").strip() for line in lines if line.startswith("data:")]
    try:
        told: Any = json.loads(stored[0] if stored else body)
    except ValueError:
        return False
    return isinstance(told, dict) and told.get("title") == TITLE


def _as_busy(start: Message) -> Message:
    headers = [*start["headers"], (b"retry-after", str(AGAIN_S).encode())]
    return {**start, "status": STATUS, "headers": headers}
