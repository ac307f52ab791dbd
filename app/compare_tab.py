"""The Compare tab: two recordings side by side, and a question about both."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import GeoTLMError

from . import stage
from .clips import SUFFIXES, load_clip, read_named
from .guards import QUESTION_CHARACTERS
from .opening import Source, examples
from .toolkit import COMPLAINT, PRIVATE, Filled, complaint, filling, gradio, literal, model_at

if TYPE_CHECKING:
    from geotlm_lm import Answerer

QUESTION = "Do they go the same way?"

FIRST_SHOWN = {"first": "bottle_cap", "second": "hex_nut"}
"""Sides, and the examples that are chosen until something else is."""


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    parts: dict[str, Any] = {}
    with gr.Row():
        for side in FIRST_SHOWN:
            with gr.Column(min_width=320):
                parts |= _side(gr, side)
    with gr.Row(elem_classes=["ask-line"]):
        parts["question"] = gr.Textbox(
            QUESTION,
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
    offered = [(source.name, key) for key, source in examples().items()]
    example = examples()[FIRST_SHOWN[side]]
    return {
        f"{side}_stage": stage.build(_unread(example)),
        f"{side}_text": gr.Markdown(),
        f"{side}_example": gr.Dropdown(
            offered, value=example.example, label=f"{side.capitalize()}: an example"
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
    chosen = [parts[f"{side}_{what}"] for side in FIRST_SHOWN for what in ("path", "example")]
    filled = [f"{side}_{what}" for side in FIRST_SHOWN for what in ("stage", "text")]
    # Not `compare`: an event takes its function's name, and that one is the programs'.
    compared = filling(parts, partial(compare_both, answerer))
    outputs = [parts[name] for name in (*filled, "verdict", COMPLAINT)]
    for trigger in (parts["go"].click, parts["question"].submit):
        trigger(compared, [parts["question"], *chosen], outputs, **model_at(parts["verdict"]))
    for side in FIRST_SHOWN:
        path, example = parts[f"{side}_path"], parts[f"{side}_example"]
        emptied = [*(parts[f"{side}_{what}"] for what in ("stage", "text")), parts["verdict"]]
        # Not queued: it would empty what a click right after the upload has filled.
        now = {**PRIVATE, "queue": False}
        upload, take = filling(parts, partial(_upload, side)), filling(parts, partial(_take, side))
        path.change(upload, [path, example], [*emptied, example, parts[COMPLAINT]], **now)
        example.input(take, example, [*emptied, path, parts[COMPLAINT]], **now)


def _upload(side: str, path: str | None, example: str | None) -> Iterator[Filled]:
    """Show what was uploaded, unless an example was chosen that took its place."""
    if path is not None or example is None:
        yield _shown(side, _source(path, None)) | {f"{side}_example": None}


def _take(side: str, example: str | None) -> Iterator[Filled]:
    yield _shown(side, _source(None, example)) | {f"{side}_path": None}


def _source(path: str | None, example: str | None) -> Source | None:
    if path:
        return Source(path, Path(path).name)
    return examples()[example] if example else None


def _shown(side: str, source: Source | None) -> Filled:
    try:
        seen = {} if source is None else _unread(source)
    except GeoTLMError:  # shown when it is compared
        seen = {}
    return {f"{side}_stage": seen, f"{side}_text": "", "verdict": ""}


def _unread(source: Source) -> dict[str, Any]:
    """Return a recording as it plays until the model is asked to look at it."""
    return stage.opening(read_named(source.path), source.name) | {"pending": False}


def compare_both(answerer: Answerer, question: str, *chosen: str | None) -> Iterator[Filled]:
    """Show both recordings as the model sees them, and answer a question about both.

    `chosen` holds of either the path of what was uploaded and the key of the example.
    """
    sources = [_source(*given) for given in zip(chosen[::2], chosen[1::2], strict=True)]
    try:
        clips = [source and load_clip(answerer, source.path) for source in sources]
        if None in clips:
            raise GeoTLMError("A comparison needs two recordings; upload both.")
        compared = answerer.compare(*(clip.encoded for clip in clips), question)
    except Exception:  # the answers about the recordings before
        yield {f"{side}_text": "" for side in FIRST_SHOWN} | {"verdict": ""}
        raise
    filled: Filled = {"verdict": f"### {literal(compared.text)}"}
    answers = (compared.first, compared.second)
    for side, clip, source, answer in zip(FIRST_SHOWN, clips, sources, answers, strict=True):
        filled[f"{side}_stage"] = stage.stage_of(clip, source.name)
        filled[f"{side}_text"] = literal(answer.text)
    yield filled
