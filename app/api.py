"""The same answers for programs: typed functions over the page's REST interface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geotlm_lm import Answerer, GeoTLMError, Touch
from geotlm_lm import evidence as evidence_of

from . import handlers
from .simulating import simulate as simulate_and_ask
from .told import MODEL, gradio, told

SNIPPET = """
```python
from gradio_client import Client, handle_file

client = Client("http://127.0.0.1:7860")
clip = handle_file("app/examples/bottle_cap_clockwise.npz")
print(client.predict(clip, "Which way is it turning?", api_name="/ask")["text"])
print(client.predict(clip, api_name="/evidence")["contact_share"])
print(client.predict(clip, clip, api_name="/compare")["relation"])
print(client.predict("key", 0.6, 15.0, 0.0, 0.0, 4.0, 0, api_name="/simulate")["answer"])
```
"""


class Api:
    """The functions programs call; each is documented where it is served.

    Args:
        answerer: The model.
        uploads: Folder that uploads are put in; a clip from elsewhere is refused.
    """

    def __init__(self, answerer: Answerer, uploads: str) -> None:
        self._answerer, self._uploads = answerer, Path(uploads).resolve()

    def ask(self, clip: dict, question: str) -> dict:
        """Answer a question about how the object in a clip moves.

        Args:
            clip: An uploaded recording: .npy, .npz, .mp4, .avi, .mov or .mkv.
            question: In plain English, at most 500 characters.

        Returns:
            text, direction (camera image, object relative to sensor), confidence, abstained,
            frame, options, evidence, timing_ms, notes, second_opinions.
        """
        return handlers.ask(self._answerer, self._shown(clip), question).details

    def evidence(self, clip: dict) -> dict:
        """Return the geometry a clip's answers rest on, without asking the language model.

        Args:
            clip: An uploaded recording.

        Returns:
            contact_share, view (pixels of a 224-pixel image), regions (shear_change_x,
            shear_change_y, contact_mass of seven regions; x right, y down, unitless),
            shear_change and contact_mask of each patch of the view, frames_used, and
            second_opinions of the linear probe and of optical flow.
        """
        shown = self._shown(clip)
        return evidence_of(shown.encoded) | {
            "shear_change": shown.seen.shear_change.round(4).tolist(),
            "contact_mask": shown.seen.mask.round(4).tolist(),
            "frames_used": list(shown.encoded.clip.frame_numbers),
            "second_opinions": shown.opinions,
        }

    def compare(self, first: dict, second: dict) -> dict:
        """Tell whether the objects in two clips move the same way.

        Args:
            first: An uploaded recording.
            second: Another.

        Returns:
            relation ("same", "opposite", "different" or "unknown"), text, both answers.
        """
        return handlers.compare(self._answerer, self._shown(first), self._shown(second))

    def simulate(
        self,
        object_name: str,
        depth_mm: float,
        twist_deg: float,
        slide_x_mm: float,
        slide_y_mm: float,
        thickness_mm: float,
        seed: int,
    ) -> dict:
        """Simulate a touch of a GelSight-like sensor and answer about it.

        Args:
            object_name: For example "key", "coin", "hex_nut".
            depth_mm: Approach beyond first touch.
            twist_deg: Turn, positive clockwise in the image.
            slide_x_mm: Travel to the right.
            slide_y_mm: Travel down the image.
            thickness_mm: Of the gel.
            seed: Of the noise.

        Returns:
            answer, direction, true_motion, is_right, and true, read and error of the amounts.
        """
        numbers = {
            "depth_mm": depth_mm,
            "twist_deg": twist_deg,
            "slide_x_mm": slide_x_mm,
            "slide_y_mm": slide_y_mm,
            "thickness_mm": thickness_mm,
        }
        touch = Touch(str(object_name), **{k: float(v) for k, v in numbers.items()}, seed=int(seed))
        return simulate_and_ask(self._answerer, touch).facts

    def _shown(self, clip: Any) -> handlers.Shown:
        return handlers.show_clip(self._answerer, self._uploaded(clip))

    def _uploaded(self, clip: Any) -> str:
        """Return the path of an upload; nothing else on this machine is opened."""
        path = clip.get("path") if isinstance(clip, dict) else clip
        inside = isinstance(path, str) and Path(path).resolve().is_relative_to(self._uploads)
        if not inside:
            raise GeoTLMError(
                "The clip is no upload; send the file itself, in Python by handle_file('clip.npz')."
            )
        return path


def build(answerer: Answerer) -> None:
    """Serve the functions and show how they are called; call it inside a `gradio.Tab`."""
    gr = gradio()
    from gradio.utils import get_upload_folder

    served = Api(answerer, get_upload_folder())
    for function in (served.ask, served.evidence, served.compare, served.simulate):
        gr.api(told(function, is_page=False), api_name=function.__name__, **MODEL)
    gr.Markdown(
        "The page is also a typed REST interface; its full description is behind *Use via API* at "
        "the foot of the page. From Python, after `pip install gradio_client`:\n" + SNIPPET
    )
