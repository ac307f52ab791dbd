"""The API tab: serves the tools to programs over REST, and shows how they are called."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, get_type_hints

from .error_display import MODEL, gradio, with_errors_shown
from .limits import SENTENCE
from .parameters import Recording
from .tools import Tool
from .uploads import Upload, path_in

SNIPPET = """
```python
from gradio_client import Client, handle_file

client = Client("http://127.0.0.1:7860")
cap = "example:bottle_cap_clockwise"
print(client.predict(cap, "Which way is it turning?", api_name="/ask")["text"])
motion = client.predict(cap, "What happens?", api_name="/ask")["motion"]
print(motion["turn"]["way"], motion["turn"]["mean"], motion["slide"]["counts"])
print(client.predict(cap, api_name="/evidence")["contact_share"])

mine = handle_file("app/examples/hex_nut_counterclockwise.npz")
print(client.predict(cap, mine, api_name="/compare")["relation"])
seen = {"viewpoint": "object", "mm_per_px": 0.06}
print(client.predict(mine, "Which way?", **seen, api_name="/ask")["direction"])
print(client.predict("key", twist_deg=15.0, slide_x_mm=0.4, api_name="/simulate")["answer"])
```
"""

REST_SNIPPET = """
```bash
url=http://127.0.0.1:7860/gradio_api
clip=$(curl -s -F files=@app/examples/bottle_cap_clockwise.npz $url/upload | cut -d'"' -f2)
asked='{"recording": "'$clip'", "question": "Which way is it turning?", "viewpoint": "object"}'
call=$(curl -s $url/call/v2/ask --json "$asked")
curl -s $url/call/ask/$(echo $call | cut -d'"' -f4)
```
"""

MCP_SNIPPET = """
```python
import asyncio, base64
from pathlib import Path
from mcp import ClientSession
from mcp.client.streamable_http import streamable_http_client


async def main():
    async with streamable_http_client("http://127.0.0.1:7860/mcp") as (read, write, _):
        async with ClientSession(read, write) as session:
            await session.initialize()
            listed = (await session.call_tool("recordings")).structuredContent
            cap = {"recording": listed["examples"][1]}
            asked = cap | {"question": "Which way is it turning?", "viewpoint": "object"}
            print((await session.call_tool("ask", asked)).structuredContent["direction"])
            track = (await session.call_tool("track", cap)).structuredContent
            print(track["totals"]["frames"], [event["event"] for event in track["events"]])
            drawn = await session.call_tool("picture", cap | {"shows": "overlay"})
            (image,) = (part for part in drawn.content if part.type == "image")
            Path("overlay.png").write_bytes(base64.b64decode(image.data))


asyncio.run(main())
```
"""


def build(tools: list[Tool]) -> None:
    """Serve the tools and show how they are called; call it inside a `gradio.Tab`."""
    gr = gradio()
    for tool in tools:
        gr.api(_typed(tool), api_name=tool.name, api_description=tool.description, **MODEL)
    gr.Markdown(
        "The page is also a typed REST interface; its full description is behind *Use via API* at "
        f"the foot of the page. {SENTENCE}\n\nFrom Python, after `pip install gradio_client`:\n"
        f"{SNIPPET}\nFrom a shell:\n{REST_SNIPPET}\nFor agents, where the page was started by "
        f"`geotlm-lm app --mcp`:\n{MCP_SNIPPET}"
    )


def _typed(tool: Tool) -> Callable[..., Any]:
    """Return a tool as the toolkit takes it: plain types, files as its clients send them."""
    signature = inspect.signature(tool.function)
    full = get_type_hints(tool.function, include_extras=True)
    plain = get_type_hints(tool.function)
    hints = {name: Upload | str if full[name] == Recording else plain[name] for name in plain}

    def call(*given: Any) -> dict[str, Any]:
        named = dict(zip(signature.parameters, map(path_in, given), strict=True))
        return tool.call(named)

    typed = [one.replace(annotation=hints[name]) for name, one in signature.parameters.items()]
    call.__signature__ = inspect.Signature(typed, return_annotation=hints["return"])
    call.__annotations__, call.__name__ = hints, tool.name
    call.__doc__ = tool.description
    return with_errors_shown(call, is_page=False)
