"""The tools for agents, over the Model Context Protocol (extra: mcp)."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from geotlm_lm import GeoTLMError, __version__
from geotlm_lm.core.errors import MissingDependency

from .limits import AT_ONCE, MESSAGE_BYTES, SENTENCE
from .tools import Tool
from .turns import LISTENER, Tell

if TYPE_CHECKING:
    from mcp.server.lowlevel import Server
    from mcp.shared.context import RequestContext

PATH = "mcp"
"""Where the protocol is served, below the page's address."""

NAME = "geotlm-lm"

INSTRUCTIONS = (
    "A camera-based touch sensor (GelSight) records how a touched object moves. Call `recordings` "
    "for the names you may use, `track` for what happens in a recording, `ask` for an answer in "
    "words with its confidence, `picture` to look. Directions are those of the camera image, of "
    f"the object relative to the sensor, unless you say otherwise. {SENTENCE}"
)


def require_mcp() -> None:
    """Refuse where the protocol's package is missing, or is one this server is not written for.

    Raises:
        MissingDependency: If it is so.
    """
    if find_spec("mcp") is None:
        raise MissingDependency(
            "--mcp needs the package mcp, which is not installed; "
            "run `pip install 'geotlm-lm[mcp]'`."
        )
    found = version("mcp")
    if not found.startswith("1."):
        raise MissingDependency(
            f"--mcp needs the package mcp from 1.30 to below 2, found {found}; "
            f"run `pip install 'geotlm-lm[mcp]'`. Clients may use any version."
        )


class AgentServer:
    """Serves tools over streamable HTTP; every request stands by itself, so none is remembered.

    Each is answered by a stream of events, not by JSON alone: it may be told of its progress.

    Args:
        tools: That agents may call.
    """

    def __init__(self, tools: list[Tool]) -> None:
        from mcp.server.streamable_http_manager import StreamableHTTPSessionManager

        self._manager = StreamableHTTPSessionManager(
            server_of(tools),
            stateless=True,
            max_request_body_size=MESSAGE_BYTES,
        )

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer a request (ASGI)."""
        await self._manager.handle_request(scope, receive, send)

    @asynccontextmanager
    async def lifespan(self, app: Any) -> AsyncIterator[None]:
        """Run as long as the page is served."""
        del app
        async with self._manager.run():
            yield


def server_of(tools: list[Tool]) -> Server:
    """Return what speaks the protocol, not yet served anywhere."""
    from anyio import CapacityLimiter, to_thread
    from mcp import types
    from mcp.server.lowlevel import Server

    server = Server(NAME, version=__version__, instructions=INSTRUCTIONS)
    known = {tool.name: tool for tool in tools}
    limiter = CapacityLimiter(AT_ONCE)

    @server.list_tools()
    async def list_tools() -> list[types.Tool]:
        return [
            types.Tool(
                name=tool.name,
                description=tool.description,
                inputSchema=tool.input_schema,
                outputSchema=tool.output_schema,
                annotations=types.ToolAnnotations(readOnlyHint=True, openWorldHint=False),
            )
            for tool in tools
        ]

    # Parameters are checked by the tool itself, whose sentences say what to do.
    @server.call_tool(validate_input=False)
    async def call_tool(name: str, arguments: dict[str, Any]) -> types.CallToolResult:
        try:
            if name not in known:
                raise GeoTLMError(f"There is no tool {name[:80]!r}; there are {', '.join(known)}.")
            LISTENER.set(_listener(server.request_context))
            result = await to_thread.run_sync(known[name].call, arguments, limiter=limiter)
        except GeoTLMError as error:
            told = [types.TextContent(type="text", text=str(error))]
            return types.CallToolResult(content=told, isError=True)
        return types.CallToolResult(content=_content(result), structuredContent=result)

    return server


def _listener(context: RequestContext[Any, Any]) -> Tell | None:
    """Return what notifies a client of how far its request is; None where it did not ask."""
    from anyio import BrokenResourceError, ClosedResourceError, from_thread

    token = None if context.meta is None else context.meta.progressToken
    if token is None:
        return None
    notify, request, last = context.session.send_progress_notification, str(context.request_id), -1

    def tell(what: str, done: int, total: int) -> None:
        nonlocal last
        # By the protocol it only grows: nothing is told of a wait, or of a second recording so far.
        if done <= last:
            return
        last = done
        try:
            from_thread.run(partial(notify, token, done, total, what, request))
        except (BrokenResourceError, ClosedResourceError) as error:
            raise GeoTLMError("The client that asked has left.") from error

    return tell


def _content(result: dict[str, Any]) -> list[Any]:
    """Return a result as JSON for those who read no structure; a picture as a picture."""
    from mcp import types

    if "png_base64" not in result:
        return [types.TextContent(type="text", text=json.dumps(result))]
    image = types.ImageContent(
        type="image", data=result.pop("png_base64"), mimeType=result["mime_type"]
    )
    return [types.TextContent(type="text", text=json.dumps(result)), image]
