"""The tools for agents, over the Model Context Protocol (extra: mcp)."""

from __future__ import annotations

import json
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import geotlm_lm as lm
from geotlm_lm.core.errors import MissingDependency, choice_of, require_package

from .guards import AT_ONCE, BUSY_STATUS, MESSAGE_BYTES, NAME_CHARACTERS, SENTENCE, Busy
from .tools import Tool
from .turns import REPORTED_EVERY_S, reported

if TYPE_CHECKING:
    from mcp.server.lowlevel import Server
    from mcp.shared.context import RequestContext

PATH = "mcp"
"""Where the protocol is served, below the page's address."""

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
    require_package("mcp", "--mcp needs the package mcp", "mcp")
    installed = version("mcp")
    if not installed.startswith("1."):
        raise MissingDependency(
            f"--mcp needs the package mcp from 1.30 to below 2, found {installed}; "
            f"run `pip install 'geotlm-lm[mcp]'`. Clients may use any version."
        )


class AgentServer:
    """Serves tools over streamable HTTP (ASGI); each request stands by itself, none is remembered.

    Each is answered by a stream of events, not by JSON alone: progress may come before the result.
    """

    def __init__(self, tools: list[Tool]) -> None:
        from mcp.server.streamable_http_manager import StreamableHTTPSessionManager

        self._manager = StreamableHTTPSessionManager(
            server_of(tools), stateless=True, max_request_body_size=MESSAGE_BYTES
        )

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer a request."""
        await self._manager.handle_request(scope, receive, send)

    @asynccontextmanager
    async def lifespan(self, _: Any) -> AsyncIterator[None]:
        """Run as long as the page is served."""
        async with self._manager.run():
            yield


def server_of(tools: list[Tool]) -> Server:
    """Return what speaks the protocol, not yet served anywhere."""
    from anyio import CapacityLimiter, to_thread
    from mcp import types
    from mcp.server.lowlevel import Server

    server = Server("geotlm-lm", version=lm.__version__, instructions=INSTRUCTIONS)
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
                raise lm.GeoTLMError(f"There is no tool {name[:80]!r}; {choice_of(name, known)}")
            call = partial(known[name].call, arguments)
            result = await to_thread.run_sync(
                _with_progress, call, server.request_context, limiter=limiter
            )
        except lm.GeoTLMError as error:
            sentence = [types.TextContent(type="text", text=str(error))]
            about = {"_meta": {"status": BUSY_STATUS}} if isinstance(error, Busy) else {}
            return types.CallToolResult(content=sentence, isError=True, **about)
        return types.CallToolResult(content=_content(result), structuredContent=result)

    return server


def _with_progress(call: Callable[[], Any], context: RequestContext) -> Any:
    """Return the result of a call, and send its progress to a client that asked for it.

    The call goes on in another thread, which never waits for the client.
    """
    from anyio import BrokenResourceError, ClosedResourceError, from_thread

    token = None if context.meta is None else context.meta.progressToken
    if token is None or len(str(token)) > NAME_CHARACTERS:
        return call()
    notify, request = context.session.send_progress_notification, str(context.request_id)
    steps, sent, sent_s = reported(call, lambda *report: report), 0, float("-inf")
    while True:
        try:
            what, done, total = next(steps)
            # By the protocol it only grows: a second recording is silent as far as the first came.
            if done > sent and time.monotonic() - sent_s >= REPORTED_EVERY_S:
                sent, sent_s = done, time.monotonic()
                from_thread.run(notify, token, done, total, what, request)
        except StopIteration as ended:
            return ended.value
        except (BrokenResourceError, ClosedResourceError):
            steps.close()
            raise lm.GeoTLMError("The client that asked has left.") from None


def _content(result: dict[str, Any]) -> list[Any]:
    """Return a result as JSON for clients that read no structure; a picture as a picture."""
    from mcp import types

    if "png_base64" not in result:
        return [types.TextContent(type="text", text=json.dumps(result))]
    image = types.ImageContent(
        type="image", data=result.pop("png_base64"), mimeType=result["mime_type"]
    )
    return [types.TextContent(type="text", text=json.dumps(result)), image]
