"""Who may call the page: whoever knows it by its own name, and no page of another site.

A site whose name is made to mean this machine (DNS rebinding) would otherwise be taken by the
browser for the page itself, and could read and send whatever the page can.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

OWN_NAMES = ("localhost", "127.0.0.1", "::1")
"""Of this machine, as it calls itself."""

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]

REFUSED = (
    "This page answers to {names} only, and to no page of another site; open it by the address "
    "that was printed when it was started.\n"
)


class OwnNamesOnly:
    """Refuses what comes by another name, or from another site, before any of it is read.

    Args:
        app: That is called for everything else (ASGI).
        names: That the page is served under, without a port.
    """

    def __init__(self, app: App, names: tuple[str, ...] = OWN_NAMES) -> None:
        self._app, self._names = app, frozenset(name.lower() for name in names)

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 403 (a websocket: close it) without reading its body."""
        if scope["type"] not in ("http", "websocket") or self._is_ours(scope["headers"]):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            told = REFUSED.format(names=", ".join(sorted(self._names))).encode()
            kind = (b"content-type", b"text/plain; charset=utf-8")
            # The body was not read: the next request cannot follow on the same connection.
            headers = [kind, (b"connection", b"close")]
            await send({"type": "http.response.start", "status": 403, "headers": headers})
            await send({"type": "http.response.body", "body": told})

    def _is_ours(self, headers: list[tuple[bytes, bytes]]) -> bool:
        hosts = [f"//{value.decode('latin-1')}" for name, value in headers if name == b"host"]
        origins = [value.decode("latin-1") for name, value in headers if name == b"origin"]
        return len(hosts) == 1 and all(name_in(one) in self._names for one in hosts + origins)


def name_in(address: str) -> str | None:
    """Return the name in an address, without its port; None where there is none."""
    try:
        return urlsplit(address).hostname
    except ValueError:  # brackets that are not closed
        return None
