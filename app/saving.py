"""Save what was found: the track and the conversation, as files that the browser makes."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode

from geotlm_lm import Exported, GeoTLMError, __version__, plot_png

from .error_display import gradio

if TYPE_CHECKING:
    from .clip_loading import LoadedClip

MIMES = {
    "csv": "text/csv",
    "json": "application/json",
    "png": "image/png",
    "txt": "text/plain",
}

SCRIPT = """
const kinds = {
  "track.csv": "Track as CSV", "track.json": "Track as JSON", "track.png": "Timeline as PNG",
  "talk.txt": "Conversation as text", "talk.json": "Conversation as JSON", "link": "Copy link",
};
const [bar, said] = element.querySelectorAll("[data-part]");
function show() {
  const value = props.value || {};
  const buttons = (value.kinds || []).map((kind) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = kinds[kind];
    button.onclick = () => trigger("click", { kind });
    return button;
  });
  bar.replaceChildren(...buttons);
  said.textContent = buttons.length
    ? "" : "Open a recording first: what is found of it is saved here.";
  if (value.link !== undefined) {
    const link = location.origin + location.pathname + value.link;
    navigator.clipboard.writeText(link).then(
      () => { said.textContent = "Link copied."; }, () => { said.textContent = link; });
  }
  if (value.content === undefined) return;
  const bytes = Uint8Array.from(atob(value.content), (one) => one.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([bytes], { type: value.mime }));
  const link = Object.assign(document.createElement("a"), { href: address, download: value.name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
  said.textContent = `${value.name} saved.`;
}
watch("value", show);
show();
"""


def bar() -> Any:
    """Return the component that offers to save; a click tells the kind, its value the file."""
    return gradio().HTML(
        {},
        html_template='<div data-part="bar"></div><p data-part="said" role="status"></p>',
        js_on_load=SCRIPT,
        apply_default_css=False,
        elem_classes=["saving"],
    )


def offered(shown: LoadedClip | None, example: str | None) -> dict[str, Any]:
    """Return what can be saved of what is open.

    Args:
        shown: The clip; None when none is open.
        example: Its key, where it is an example: only those have a link.
    """
    if shown is None:
        return {"kinds": []}
    tracked = [] if shown.encoded.track is None else ["track.csv", "track.json", "track.png"]
    said = ["talk.txt", "talk.json"] if shown.session.history else []
    return {"kinds": [*tracked, *said, *(["link"] if example else [])]}


def saved(kind: str, shown: LoadedClip | None, name: str, example: str | None) -> dict[str, Any]:
    """Return a file for the browser to save, or the end of a link.

    Args:
        kind: One of those offered.
        shown: The clip that is open.
        name: What the page calls it.
        example: Its key, where it is an example.

    Raises:
        GeoTLMError: If nothing of this kind can be saved, or its package is missing.
    """
    told = offered(shown, example)
    if shown is None or kind not in told["kinds"]:
        raise GeoTLMError("There is nothing of this kind to save; open a recording and ask first.")
    if kind == "link":
        questions = [turn.question for turn in shown.session.history]
        asked = {"q": questions[-1]} if questions else {}
        return told | {"link": f"?{urlencode({'example': example} | asked)}"}
    of, ending = kind.split(".")
    content = _track(shown, ending, name) if of == "track" else _talk(shown, ending)
    stem = "".join(one if one.isalnum() else "_" for one in Path(name).stem)
    return told | {
        "name": f"{stem}_{'track' if of == 'track' else 'conversation'}.{ending}",
        "mime": MIMES[ending],
        "content": base64.b64encode(content).decode(),
    }


def _track(shown: LoadedClip, ending: str, name: str) -> bytes:
    exported = Exported(shown.encoded.track, shown.session.frame.mm_per_px)
    clip = shown.encoded.recording
    if ending == "png":
        return plot_png(exported, in_frames=not clip.is_timed)
    made_by = {"program": f"geotlm-lm {__version__}", "recording": name, "fps": clip.fps}
    return exported.content(f".{ending}", made_by)


def _talk(shown: LoadedClip, ending: str) -> bytes:
    if ending == "json":
        return (json.dumps(shown.session.to_dict(), indent=1) + "\n").encode()
    turns = shown.session.history
    return "\n\n".join(f"{one.question}\n{one.answer.text}" for one in turns).encode() + b"\n"
