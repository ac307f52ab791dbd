"""Nothing is fetched from elsewhere for whoever asks: a file is sent, its address is not enough.

The toolkit would download what an input of the page names by an address, and would pass on what the
address of a file leads to: anybody at the page could have this machine fetch anything.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .error_display import gradio
from .own_names import App, Message, Receive, Send, refuse

REFUSED = "Files are not fetched from an address; upload the file itself."

FETCHED = ("/file=http:", "/file=https:", "/proxy=")
"""Parts of the addresses at which the toolkit passes on what it fetches."""


class NoAddresses:
    """Passes on what does not make the server fetch something.

    Args:
        app: That is called for it (ASGI).
    """

    def __init__(self, app: App) -> None:
        self._app = app

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 403."""
        if scope["type"] == "http" and any(one in scope["path"].lower() for one in FETCHED):
            await refuse(send, 403, REFUSED)
            return
        await self._app(scope, receive, send)


def refuse_addresses(page: Any) -> None:
    """Have a page take no file by its address, in any of its inputs.

    Args:
        page: The `gradio.Blocks`.
    """
    taken = page.preprocess_data

    async def preprocess_data(function: Any, inputs: list[Any], *rest: Any, **named: Any) -> Any:
        if any("://" in one for one in _paths_in(inputs)):
            raise gradio().Error(REFUSED, print_exception=False)
        return await taken(function, inputs, *rest, **named)

    page.preprocess_data = preprocess_data


def _paths_in(value: Any) -> Iterator[str]:
    """Yield the path of every file in what a page was sent."""
    if isinstance(value, dict):
        path = value.get("path")
        if isinstance(path, str):
            yield path
        value = list(value.values())
    if isinstance(value, list | tuple):
        for one in value:
            yield from _paths_in(one)
