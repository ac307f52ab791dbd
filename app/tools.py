"""Tools as programs and agents see them: typed, checked, with schemas; errors in one sentence.

Programs call them over REST, agents over the Model Context Protocol (extra: mcp).
"""

from __future__ import annotations

import inspect
import json
import logging
import time
from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, get_type_hints

import gradio as gr
from anyio import BrokenResourceError, CapacityLimiter, ClosedResourceError, from_thread, to_thread
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, create_model

import geotlm_lm as lm
from geotlm_lm.core.errors import MissingDependency, choice_of, require_package

from . import guards
from .schema import Recording
from .sources import Upload, path_in
from .toolkit import MODEL
from .turns import REPORTED_EVERY_S, reported

if TYPE_CHECKING:
    from mcp.server.lowlevel import Server
    from mcp.server.streamable_http_manager import StreamableHTTPSessionManager
    from mcp.shared.context import RequestContext

logger = logging.getLogger(__name__)

OUR_FAULT = "The tool failed, and it is not your fault; the server's log has the reason."

INSTRUCTIONS = (
    "A camera-based touch sensor (GelSight) records how a touched object moves. Call `recordings` "
    "for the names you may use, `track` for what happens in a recording, `ask` for an answer in "
    "words with its confidence, `picture` to look. Directions are those of the camera image, of "
    f"the object relative to the sensor, unless you say otherwise. {guards.SENTENCE}"
)


class Tool:
    """A function that programs and agents call by name; its parameters and result are annotated.

    A parameter that is a model of several stands for them: each is a parameter of the tool. What it
    takes and returns is described by JSON Schemas.
    """

    def __init__(self, function: Callable[..., dict[str, Any]]) -> None:
        self.function, self.name = function, function.__name__
        self.description = inspect.getdoc(function) or ""
        hints = get_type_hints(function, include_extras=True)
        self.groups: dict[str, type[BaseModel]] = {
            name: kind
            for name, kind in hints.items()
            if isinstance(kind, type) and issubclass(kind, BaseModel)
        }
        fields: dict[str, Any] = {}
        for name, parameter in inspect.signature(function).parameters.items():
            if name in self.groups:
                shared = self.groups[name].model_fields.items()
                fields |= {each: (field.annotation, field) for each, field in shared}
            else:
                is_needed = parameter.default is inspect.Parameter.empty
                fields[name] = (hints[name], ... if is_needed else parameter.default)
        self.parameters = create_model(self.name, __config__=ConfigDict(extra="forbid"), **fields)
        self.output = TypeAdapter(hints["return"])
        self.input_schema = _without_titles(self.parameters.model_json_schema())
        self.output_schema = _without_titles(self.output.json_schema(mode="serialization"))

    def call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return the function's result as plain JSON values.

        Raises:
            GeoTLMError: If a parameter is wrong, or the function cannot do what is asked, in one
                sentence; a defect is logged with its trace and reported as one.
        """
        try:
            checked = self.parameters.model_validate(dict(given))
        except ValidationError as error:
            raise lm.GeoTLMError(self._sentence(error)) from None
        arguments = dict(checked)
        for name, group in self.groups.items():
            arguments[name] = group(**{each: arguments.pop(each) for each in group.model_fields})
        try:
            result = self.function(**arguments)
            return self.output.dump_python(result, mode="json", warnings=False)
        except lm.GeoTLMError:
            raise
        except Exception as error:
            logger.exception("the tool %s failed", self.name)
            raise lm.GeoTLMError(OUR_FAULT) from error

    def serve(self) -> None:
        """Serve the tool over REST; call it inside the `gradio.Blocks`."""
        gr.api(self._typed(), api_name=self.name, api_description=self.description, **MODEL)

    def _typed(self) -> Callable[..., Any]:
        """Return the tool as the toolkit takes it: plain types, files as its clients send them."""
        full = get_type_hints(self.parameters, include_extras=True)
        plain, names = get_type_hints(self.parameters), list(self.parameters.model_fields)
        hints = {name: Upload | str if full[name] == Recording else plain[name] for name in names}

        def call(*given: Any) -> dict[str, Any]:
            try:
                return self.call(dict(zip(names, map(path_in, given), strict=True)))
            except lm.GeoTLMError as error:
                title = {"title": guards.BUSY_TITLE} if isinstance(error, guards.Busy) else {}
                raise gr.Error(str(error), print_exception=False, **title) from error

        hints["return"] = get_type_hints(self.function)["return"]
        typed = [
            parameter.replace(annotation=hints[name], kind=parameter.POSITIONAL_OR_KEYWORD)
            for name, parameter in inspect.signature(self.parameters).parameters.items()
        ]
        call.__signature__ = inspect.Signature(typed, return_annotation=hints["return"])
        call.__annotations__, call.__name__, call.__doc__ = hints, self.name, self.description
        return call

    def _sentence(self, error: ValidationError) -> str:
        """Return the first of what is wrong with the parameters."""
        first = error.errors(include_url=False)[0]
        name = ".".join(map(str, first["loc"]))
        fields = self.parameters.model_fields
        if first["type"] == "missing":
            needed = [name for name, field in fields.items() if field.is_required()]
            return f"{self.name}: {name} is missing; give {' and '.join(needed)}."
        if first["type"] == "extra_forbidden":
            advice = choice_of(name, fields) if fields else "it takes none."
            return f"{self.name}: there is no parameter {name[:80]!r}; {advice}"
        value, reason = repr(first["input"]), first["msg"]
        return (
            f"{self.name}: {name} was {value if len(value) <= 40 else f'{value[:37]}...'}, and "
            f"{reason[:1].lower()}{reason[1:]}; the tool's schema says what it may be."
        )


def _without_titles(schema: Any) -> Any:
    """Return a schema without the titles that repeat each name."""
    if isinstance(schema, list):
        return [_without_titles(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        name: _without_titles(part)
        for name, part in schema.items()
        if not (name == "title" and isinstance(part, str))
    }


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


def manager_of(tools: list[Tool]) -> StreamableHTTPSessionManager:
    """Return what serves tools over streamable HTTP; each request stands by itself.

    Each is answered by a stream of events, not by JSON alone: progress may come before the result.
    """
    from mcp.server.streamable_http_manager import StreamableHTTPSessionManager

    return StreamableHTTPSessionManager(
        server_of(tools), stateless=True, max_request_body_size=guards.MESSAGE_BYTES
    )


def server_of(tools: list[Tool]) -> Server:
    """Return what speaks the protocol, not yet served anywhere."""
    from mcp import types
    from mcp.server.lowlevel import Server

    server = Server("geotlm-lm", version=lm.__version__, instructions=INSTRUCTIONS)
    known = {tool.name: tool for tool in tools}
    limiter = CapacityLimiter(guards.AT_ONCE)

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
            meta = {"status": guards.BUSY_STATUS} if isinstance(error, guards.Busy) else None
            return types.CallToolResult(content=sentence, isError=True, _meta=meta)
        return types.CallToolResult(content=_content(result), structuredContent=result)

    return server


def _with_progress(call: Callable[[], Any], context: RequestContext) -> Any:
    """Return the result of a call, and send its progress to a client that asked for it.

    The call goes on in another thread, which never waits for the client.
    """
    token = None if context.meta is None else context.meta.progressToken
    if token is None or len(str(token)) > guards.NAME_CHARACTERS:
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
