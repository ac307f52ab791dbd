"""The Ask tab: the stage and its timeline on the left, the conversation on the right."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gradio as gr

import geotlm_lm as lm

from . import conversation, opening, stage
from .clips import SUFFIXES
from .guards import TOPIC_CHARACTERS
from .opening import Opening
from .talking import Talking
from .toolkit import MODEL, QUIET, Filled, html, on

ANSWERED = (
    *("chat", "evidence", "code", "last", "question", "frame", "mm_per_px", "framed", "chips"),
    *("saving", "stage", "stage_second"),
)
"""What is filled when a question is answered."""

OPENED = (
    *(name for name in ANSWERED if name not in ("question", "frame")),
    *("shown", "source", "reading", "first", "last_frame", "topic", "files"),
)
"""What is filled when a recording is opened or closed."""


def build(answerer: lm.Answerer, page: Any) -> None:
    """Lay the tab out and connect it; an example is opened with the page (a `gradio.Blocks`)."""
    states = ("shown", "source", "reading", "last")
    parts: dict[str, Any] = {name: gr.State() for name in states}
    with gr.Row(elem_classes=["ask"]):
        with gr.Column(elem_classes=["ask-talk"]):
            parts |= conversation.talk()
        with gr.Column(elem_classes=["ask-stage"]):
            parts["stage"] = stage.build(actions=stage.COMPARE)
            parts["stage_second"] = stage.build(CHOOSE_SECOND, stage.CLOSE, "stage-second")
    with gr.Row(elem_classes=["gallery"]):
        parts["files"] = gr.File(
            label="Recording",
            file_types=SUFFIXES,
            file_count="multiple",
            type="filepath",
            height=84,
            elem_classes=["drop"],
        )
        parts["examples"] = opening.strip()
    with conversation.drawer():
        parts |= _details()
    talking = Talking(answerer)
    opens = Opening(answerer, talking)
    _connect_opening(parts, opens, page)
    page.warm = opens.warm
    conversation.connect(parts, talking, "shown", ANSWERED)
    _connect_saving(parts)


def _details() -> dict[str, Any]:
    """Lay out what is in the drawer."""
    parts: dict[str, Any] = {"evidence": html({}, "<div></div>", "evidence")}
    parts |= conversation.frame_of_reference()
    gr.Markdown("#### Part of the recording")
    with gr.Row():
        # Text: of a number field left empty the page makes 0, which is a frame.
        parts["first"] = gr.Textbox(label="First frame", max_length=9, min_width=80)
        parts["last_frame"] = gr.Textbox(label="Last frame", max_length=9, min_width=80)
        parts["topic"] = gr.Textbox(
            label="Topic of a bag", max_length=TOPIC_CHARACTERS, min_width=120
        )
    parts["read"] = gr.Button("Read again with these")
    gr.Markdown("#### Code")
    parts["code"] = html("", CODE, "code")
    gr.Markdown("#### Save and share")
    parts["saving"] = opening.saving_bar()
    gr.HTML(PROGRAMS, apply_default_css=False)
    return parts


CHOOSE_SECOND = (
    "Choose a second recording among the examples, or drop one here: questions are about both."
)

CODE = '<button type="button" hidden>Copy</button><pre tabindex="0" aria-label="Code"></pre>'

PROGRAMS = '<p class="note"><a href="?view=api">The same for programs: REST, Python, MCP</a></p>'


def _connect_opening(parts: dict[str, Any], opens: Opening, page: Any) -> None:
    before = ("frame", "mm_per_px", "shown")
    at_stage, files = {**QUIET, **MODEL}, parts["files"]

    def open_example(event: gr.EventData, *now: Any) -> Iterator[Filled]:
        yield from opens.example(str(event._data.get("example")), *now)

    def visit(request: gr.Request) -> Iterator[Filled]:
        yield from opens.visit(request.query_params)

    changed = (files.upload, files.clear, files.delete)
    on(parts, changed, opens.upload, ("files", *before), OPENED, **at_stage)
    on(parts, [parts["examples"].click], open_example, before, OPENED, **at_stage)
    spanned = ("source", "first", "last_frame", "topic", *before)
    on(parts, [parts["read"].click], opens.read_again, spanned, OPENED, **at_stage)
    compares = ("stage_second", "shown")
    on(parts, [parts["stage"].expand], opens.compare, ["shown"], compares, queue=False)
    closing = parts["stage_second"].collapse
    on(parts, [closing], opens.close_second, ["shown"], OPENED, **at_stage)
    on(parts, [page.load], visit, (), (*OPENED, "question", "frame"), **at_stage)
    stopped = (parts["stage"].stop, parts["stage_second"].stop)
    on(parts, stopped, opens.stop, ["reading"], queue=False, **QUIET)


def _connect_saving(parts: dict[str, Any]) -> None:
    def save(shown: Any, event: gr.EventData) -> Iterator[Filled]:
        yield {"saving": opening.saved(str(event._data.get("kind")), shown)}

    on(parts, [parts["saving"].click], save, ["shown"], ["saving"])
