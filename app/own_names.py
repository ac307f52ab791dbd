"""Who may call the page: whoever knows it by its own name, and no page of another site.

A site whose name is made to mean this machine (DNS rebinding) would otherwise be taken by the
browser for the page itself, and could read and send whatever the page can.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass
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
    "that was printed when it was started."
)


async def refuse(send: Send, status: int, sentence: str, *more: tuple[bytes, bytes]) -> None:
    """Answer a request whose body was not read: none can follow on the same connection.

    Args:
        send: Of the request (ASGI).
        status: Of HTTP.
        sentence: That says why, and what to do.
        more: Headers.
    """
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close"), *more]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": f"{sentence}\n".encode()})


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
            await refuse(send, 403, REFUSED.format(names=", ".join(sorted(self._names))))

    def _is_ours(self, headers: list[tuple[bytes, bytes]]) -> bool:
        hosts = [f"http://{value.decode('latin-1')}" for name, value in headers if name == b"host"]
        origins = [value.decode("latin-1") for name, value in headers if name == b"origin"]
        if len(hosts) != 1:
            return False
        host = place_of(hosts[0])
        # The port it was asked for is not always the one it listens on: it may be forwarded.
        return host.name in self._names and all(place_of(one) == host for one in origins)


@dataclass(frozen=True)
class Place:
    """Whom an address leads to.

    Args:
        name: Without the port; None where there is none.
        port: None for the scheme's own.
    """

    name: str | None = None
    port: int | None = None


def place_of(address: str) -> Place:
    """Return whom an address leads to; nobody where it makes no sense."""
    try:
        parts = urlsplit(address)
        port = parts.port
    except ValueError:  # brackets that are not closed, a port that is no number
        return Place()
    return Place(parts.hostname, None if port == USUAL_PORT.get(parts.scheme) else port)


USUAL_PORT = {"http": 80, "https": 443}
"""Of an address that names none."""
