"""The same answers for programs: typed functions over REST and, with the extra, over MCP."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from . import clip_loading, handlers
from .error_display import MODEL, gradio, with_errors_shown
from .results import AnswerResult, ComparisonResult, EvidenceFields, SimulatedAnswer
from .simulation_handlers import simulate as simulate_and_ask
from .simulation_handlers import touch_of
from .uploads import Upload, Uploads

if TYPE_CHECKING:
    from geotlm_lm import Answerer

SNIPPET = """
```python
from gradio_client import Client, handle_file

client = Client("http://127.0.0.1:7860")
clip = handle_file("app/examples/bottle_cap_clockwise.npz")
print(client.predict(clip, "Which way is it turning?", api_name="/ask")["text"])
motion = client.predict(clip, "What happens?", api_name="/ask")["motion"]
print(motion["turn"]["way"], motion["turn"]["mean"], motion["slide"]["counts"])
print(client.predict(clip, api_name="/evidence")["contact_share"])
print(client.predict(clip, clip, api_name="/compare")["relation"])
print(client.predict("key", 0.6, 15.0, 0.4, 0.0, 0.1, 4.0, 0, api_name="/simulate")["answer"])
```
"""

REST_SNIPPET = """
```bash
url=http://127.0.0.1:7860/gradio_api
clip=$(curl -s -F files=@app/examples/bottle_cap_clockwise.npz $url/upload | cut -d'"' -f2)
asked='{"data": ["'$clip'", "Which way is it turning?"]}'
call=$(curl -s $url/call/ask --json "$asked")
curl -s $url/call/ask/$(echo $call | cut -d'"' -f4)
```
"""

MCP_SNIPPET = """
```python
import asyncio, base64, json
from pathlib import Path
from mcp import ClientSession
from mcp.client.streamable_http import streamable_http_client


async def main():
    stored = Path("app/examples/bottle_cap_clockwise.npz").read_bytes()
    clip = "data:;base64," + base64.b64encode(stored).decode()
    async with streamable_http_client("http://127.0.0.1:7860/gradio_api/mcp/") as (read, write, _):
        async with ClientSession(read, write) as session:
            await session.initialize()
            asked = {"clip": clip, "question": "Which way is it turning?"}
            answer = await session.call_tool("ask", asked)
            print(json.loads(answer.content[0].text)["direction"])


asyncio.run(main())
```
"""


class Api:
    """The functions programs call; each is documented where it is served.

    Args:
        answerer: The model.
        uploads: Finds the recordings that were sent.
    """

    def __init__(self, answerer: Answerer, uploads: Uploads) -> None:
        self._answerer, self._uploads = answerer, uploads

    def ask(self, clip: Upload | str, question: str) -> AnswerResult:
        """Answer a question about how the object in a clip moves.

        Args:
            clip: Recording: an upload, its address, or a data URI in base64.
            question: In plain English.

        Returns:
            Words, direction (camera image, object relative to sensor), confidence, evidence.
        """
        return handlers.ask(self._answerer, self._shown(clip), question).details

    def evidence(self, clip: Upload | str) -> EvidenceFields:
        """Return the geometry a clip's answers rest on, without asking the language model.

        Args:
            clip: Recording: an upload, its address, or a data URI in base64.

        Returns:
            Contact, shear change of seven regions and of each patch; x right, y down, unitless.
        """
        from geotlm_lm import regions_of

        shown = self._shown(clip)
        return regions_of(shown.encoded) | {
            "shear_change": shown.seen.shear_change.round(4).tolist(),
            "contact_mask": shown.seen.mask.round(4).tolist(),
            "frames_used": list(shown.encoded.clip.frame_numbers),
            "second_opinions": shown.opinions,
        }

    def compare(self, first: Upload | str, second: Upload | str) -> ComparisonResult:
        """Tell whether the objects in two clips move the same way.

        Args:
            first: Recording: an upload, its address, or a data URI in base64.
            second: Another.

        Returns:
            The relation (same, opposite, different or unknown), in words too, and both answers.
        """
        return handlers.compare(self._answerer, self._shown(first), self._shown(second))

    def simulate(
        self,
        object_name: str,
        depth_mm: float,
        twist_deg: float,
        slide_x_mm: float,
        slide_y_mm: float,
        press_mm: float,
        thickness_mm: float,
        seed: int,
    ) -> SimulatedAnswer:
        """Simulate a touch of a GelSight-like sensor and answer about it.

        Args:
            object_name: For example "key", "coin", "hex_nut".
            depth_mm: Approach beyond first touch, half-way.
            twist_deg: Turn, positive clockwise in the image.
            slide_x_mm: Travel to the right.
            slide_y_mm: Travel down the image.
            press_mm: Approach into the gel; negative lifts.
            thickness_mm: Of the gel.
            seed: Of the noise.

        Returns:
            Which way it goes and how far, in words; the true motion, which components count, the
            true amounts, the ones in the learned shear, and their error.
        """
        numbers = {
            "depth_mm": depth_mm,
            "twist_deg": twist_deg,
            "slide_x_mm": slide_x_mm,
            "slide_y_mm": slide_y_mm,
            "press_mm": press_mm,
            "thickness_mm": thickness_mm,
        }
        return simulate_and_ask(self._answerer, touch_of(object_name, numbers, seed)).facts

    def _shown(self, clip: Any) -> clip_loading.LoadedClip:
        return clip_loading.load_clip(self._answerer, self._uploads.path_of(clip))


def build(answerer: Answerer) -> None:
    """Serve the functions and show how they are called; call it inside a `gradio.Tab`."""
    gr = gradio()
    from gradio.utils import get_upload_folder

    served = Api(answerer, Uploads(get_upload_folder()))
    for function in (served.ask, served.evidence, served.compare, served.simulate):
        gr.api(_typed(function), api_name=function.__name__, **MODEL)
    gr.Markdown(
        "The page is also a typed REST interface; its full description is behind *Use via API* at "
        "the foot of the page. From Python, after `pip install gradio_client`:\n"
        f"{SNIPPET}\nFrom a shell:\n{REST_SNIPPET}\nFor agents, where the page was started by "
        f"`geotlm-lm app --mcp`:\n{MCP_SNIPPET}"
    )


def _typed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function with its errors told, and its types as types: postponed they are text."""
    shown = with_errors_shown(function, is_page=False)
    shown.__signature__ = inspect.signature(function, eval_str=True)
    return shown
