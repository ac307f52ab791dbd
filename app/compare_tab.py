"""The Compare tab: two recordings side by side, and a question about both."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import GeoTLMError

from . import handlers, stage
from .clip_loading import SUFFIXES, load_clip, read_named
from .error_display import gradio, literal, model_at
from .example_clips import examples
from .filling import COMPLAINT, Filled, complaint, filling
from .limits import QUESTION_CHARACTERS

if TYPE_CHECKING:
    from geotlm_lm import Answerer

SIDES = ("first", "second")

FIRST_SHOWN = {"first": "bottle_cap", "second": "hex_nut"}
"""Examples that are chosen until something else is."""


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    parts: dict[str, Any] = {}
    with gr.Row():
        for side in SIDES:
            with gr.Column(min_width=320):
                parts |= _side(gr, side)
    with gr.Row(elem_classes=["ask-line"]):
        parts["question"] = gr.Textbox(
            handlers.COMPARISON_QUESTION,
            label="Question about both",
            show_label=False,
            container=False,
            max_length=QUESTION_CHARACTERS,
            scale=6,
            elem_classes=["question"],
        )
        parts["go"] = gr.Button("Compare", variant="primary", scale=1)
    parts[COMPLAINT] = complaint()
    parts["verdict"] = gr.Markdown()
    _connect(parts, answerer)


def _side(gr: Any, side: str) -> dict[str, Any]:
    offered = [(one.name, one.key) for one in examples().values()]
    example = examples()[FIRST_SHOWN[side]]
    return {
        f"{side}_stage": stage.build(_unread(example.path, example.name)),
        f"{side}_text": gr.Markdown(),
        f"{side}_example": gr.Dropdown(
            offered, value=example.key, label=f"{side.capitalize()}: an example"
        ),
        f"{side}_path": gr.File(
            label=f"{side.capitalize()} recording",
            file_types=SUFFIXES,
            type="filepath",
            height=96,
            elem_classes=["drop"],
        ),
    }


def _connect(parts: dict[str, Any], answerer: Answerer) -> None:
    chosen = [parts[f"{side}_{what}"] for side in SIDES for what in ("path", "example")]
    filled = [f"{side}_{what}" for side in SIDES for what in ("stage", "text")]
    # Not `compare`: an event takes its function's name, and that one is the programs'.
    compared = filling(parts, partial(compare_both, answerer))
    outputs = [parts[name] for name in (*filled, "verdict", COMPLAINT)]
    for trigger in (parts["go"].click, parts["question"].submit):
        trigger(compared, [parts["question"], *chosen], outputs, **model_at(parts["verdict"]))
    for side in SIDES:
        path, example = parts[f"{side}_path"], parts[f"{side}_example"]
        emptied = [*(parts[f"{side}_{one}"] for one in ("stage", "text")), parts["verdict"]]
        # Not queued: it would empty what a click right after the upload has told.
        now = {"api_visibility": "private", "queue": False}
        given, taken = filling(parts, partial(_given, side)), filling(parts, partial(_chosen, side))
        path.change(given, [path, example], [*emptied, example, parts[COMPLAINT]], **now)
        example.input(taken, example, [*emptied, path, parts[COMPLAINT]], **now)


def _given(side: str, path: str | None, example: str | None) -> Iterator[Filled]:
    """Show what was uploaded, unless an example was chosen that took its place."""
    if path is None and example is not None:
        return
    yield _shown(side, path) | {f"{side}_example": None}


def _chosen(side: str, example: str | None) -> Iterator[Filled]:
    path = None if example is None else examples()[example].path
    yield _shown(side, path, example) | {f"{side}_path": None}


def _shown(side: str, path: str | None, example: str | None = None) -> Filled:
    try:
        seen = {} if path is None else _unread(path, _name(path, example))
    except GeoTLMError:  # told when it is compared
        seen = {}
    return {f"{side}_stage": seen, f"{side}_text": "", "verdict": ""}


def _unread(path: str, name: str) -> dict[str, Any]:
    """Return a recording as it plays until the model is asked to look at it."""
    return stage.opening(read_named(path), name) | {"pending": False}


def _name(path: str, example: str | None) -> str:
    return Path(path).name if example is None else examples()[example].name


def compare_both(answerer: Answerer, question: str, *chosen: str | None) -> Iterator[Filled]:
    """Show both recordings as the model sees them, and answer a question about both.

    Args:
        answerer: The model.
        question: About both.
        chosen: Of either, path of what was uploaded and key of the example.

    Raises:
        GeoTLMError: If a recording is missing or cannot be used.
    """
    given = list(zip(chosen[::2], chosen[1::2], strict=True))
    try:
        shown = []
        for path, example in given:
            path = path or (examples()[example].path if example else None)
            shown.append(load_clip(answerer, path) if path else None)
        told = handlers.compare(answerer, *shown, question)
    except Exception:  # what was said of the recordings before
        yield {f"{side}_text": "" for side in SIDES} | {"verdict": ""}
        raise
    filled: Filled = {"verdict": f"### {literal(told['text'])}"}
    for side, clip, (path, example) in zip(SIDES, shown, given, strict=True):
        name = Path(path).name if path else examples()[example].name
        filled[f"{side}_stage"] = stage.stage_of(clip, name)
        filled[f"{side}_text"] = literal(told[side]["text"])
    yield filled
