"""A request that found the memory taken is answered by HTTP status 429, whatever protocol it has.

What it needs is known only while it is worked on, when the toolkit and the agents' protocol have
already begun to answer; so the beginning of an answer waits for the first of what is answered.
"""

from __future__ import annotations

import json
from typing import Any

from .budget import AGAIN_S, STATUS, TITLE
from .own_names import App, Message, Receive, Send

LONGEST_BYTES = 4096
"""Of what tells a mistake."""


class BusyStatus:
    """Gives the status to answers that say so.

    Args:
        app: That answers (ASGI).
        agents: Address of the agents' protocol.
    """

    def __init__(self, app: App, agents: str) -> None:
        self._app, self._agents = app, agents

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on; what is answered to a tool's call waits for its first part."""
        if scope["type"] != "http" or not self._is_call(scope["method"], scope["path"]):
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

    def _is_call(self, method: str, path: str) -> bool:
        if path == self._agents:
            return method == "POST"
        return "/call/" in path or "/run/" in path


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
    if not isinstance(told, dict):
        return False
    result = told.get("result")
    about = result.get("_meta") if isinstance(result, dict) else None
    return told.get("title") == TITLE or (isinstance(about, dict) and about.get("status") == STATUS)


def _as_busy(start: Message) -> Message:
    headers = [*start["headers"], (b"retry-after", str(AGAIN_S).encode())]
    return {**start, "status": STATUS, "headers": headers}
