"""The recordings on offer, named after what is touched: how it moves is for the model to tell."""

from __future__ import annotations

import base64
from dataclasses import dataclass, replace
from functools import cache
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2

from geotlm_lm import Motion, camera_size, read_clip

from .error_display import gradio

if TYPE_CHECKING:
    from geotlm_lm import Answerer

    from .clip_loading import LoadedClip

FOLDER = Path(__file__).parent / "examples"

FIRST = "bottle_cap"
"""Opened with the page: its turn is easily followed by eye."""

THUMBNAIL_PX = 104

SCRIPT = """
element.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (button) trigger("click", { example: button.dataset.example });
});
"""


@dataclass(frozen=True)
class Example:
    """A recording on offer.

    Args:
        key: What links call it.
        name: What the page calls it.
        path: Of its file.
    """

    key: str
    name: str
    path: str


@cache
def examples() -> dict[str, Example]:
    """Return the recordings on offer by their keys, the one that is opened first before all."""
    found: dict[str, Example] = {}
    for path in sorted(FOLDER.glob("*.npz")):
        touched = path.stem
        for motion in sorted(Motion, key=lambda one: -len(one)):
            touched = touched.removesuffix(f"_{motion.value}")
        count = 1 + sum(one.rstrip("_23456789") == touched for one in found)
        key = touched if count == 1 else f"{touched}_{count}"
        found[key] = Example(key, key.replace("_", " "), str(path))
    return dict(sorted(found.items(), key=lambda one: one[0] != FIRST))


def strip() -> Any:
    """Return the component that shows them; a click on one tells its key."""
    return gradio().HTML(
        "",
        html_template=_markup(),
        js_on_load=SCRIPT,
        apply_default_css=False,
        elem_classes=["examples"],
    )


def perceived(answerer: Answerer, example: Example, known: dict[str, LoadedClip]) -> LoadedClip:
    """Return an example as the model sees it, looked at once, with a conversation of its own.

    Args:
        answerer: The model.
        example: Which.
        known: Those that were looked at before.
    """
    from .clip_loading import load_clip

    if example.key not in known:
        known[example.key] = load_clip(answerer, example.path)
    return replace(known[example.key], session=answerer.session(known[example.key].encoded))


@cache
def _markup() -> str:
    buttons = [
        f'<button type="button" class="example" data-example="{escape(one.key)}">'
        f'<img src="{_thumbnail(one.path)}" alt="" width="{THUMBNAIL_PX}">'
        f"<span>{escape(one.name)}</span></button>"
        for one in examples().values()
    ]
    return f'<div role="group" aria-label="Examples">{"".join(buttons)}</div>'


def _thumbnail(path: str) -> str:
    frame = read_clip(path).frames[-1]
    rows, columns = camera_size(*frame.shape[:2])
    size = (THUMBNAIL_PX, round(THUMBNAIL_PX * rows / columns))
    small = cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
    stored = cv2.imencode(".jpg", cv2.cvtColor(small, cv2.COLOR_RGB2BGR))[1].tobytes()
    return f"data:image/jpeg;base64,{base64.b64encode(stored).decode()}"
