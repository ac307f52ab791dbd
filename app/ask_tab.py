"""The Ask tab: the stage and its timeline on the left, the conversation on the right."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import geotlm_lm as lm

from . import conversation, opening, stage
from .clips import SUFFIXES
from .guards import TOPIC_CHARACTERS
from .opening import Opening
from .talking import Talking
from .toolkit import COMPLAINT, MODEL, PRIVATE, QUIET, Filled, filling, gradio, html

ANSWERED = (
    *("chat", "evidence", "code", "last", "question", "frame", "mm_per_px", "framed", "chips"),
    *("saving", "stage", "stage_second", COMPLAINT),
)
"""What is filled when a question is answered."""

OPENED = (
    *(name for name in ANSWERED if name not in ("question", "frame")),
    *("shown", "source", "reading", "first", "last_frame", "topic", "files"),
)
"""What is filled when a recording is opened or closed."""


def build(answerer: lm.Answerer, page: Any) -> None:
    """Lay the tab out and connect it; an example is opened with the page (a `gradio.Blocks`)."""
    gr = gradio()
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
        parts |= _details(gr)
    talking = Talking(answerer)
    opens = Opening(answerer, talking)
    _connect_opening(gr, parts, opens, page)
    page.warm = opens.warm
    conversation.connect(parts, talking, "shown", ANSWERED)
    _connect_saving(gr, parts)


def _details(gr: Any) -> dict[str, Any]:
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


def _connect_opening(gr: Any, parts: dict[str, Any], opens: Opening, page: Any) -> None:
    before = [parts[name] for name in ("frame", "mm_per_px", "shown")]
    outputs = [parts[name] for name in OPENED]
    asked = [parts[name] for name in ("question", "frame")]
    at_stage = {**QUIET, **MODEL}
    files, upload = parts["files"], filling(parts, opens.upload)
    for trigger in (files.upload, files.clear, files.delete):
        trigger(upload, [files, *before], outputs, **at_stage)

    def open_example(*given: Any) -> Iterator[Filled]:
        *now, event = given
        yield from opens.example(str(event._data.get("example")), *now)

    clicked = filling(parts, open_example, gr.EventData)
    parts["examples"].click(clicked, before, outputs, **at_stage)
    spanned = [parts[name] for name in ("source", "first", "last_frame", "topic")]
    again = filling(parts, opens.read_again)
    parts["read"].click(again, [*spanned, *before], outputs, **at_stage)

    compares = [parts[name] for name in ("stage_second", "shown", COMPLAINT)]
    comparing = filling(parts, opens.compare)
    parts["stage"].expand(comparing, parts["shown"], compares, queue=False, **PRIVATE)
    closing = filling(parts, opens.close_second)
    parts["stage_second"].collapse(closing, parts["shown"], outputs, **at_stage)

    def visit(request: Any) -> Iterator[Filled]:
        yield from opens.visit(request.query_params)

    page.load(filling(parts, visit, gr.Request), None, outputs + asked, **at_stage)
    stopping, shown = filling(parts, opens.stop), [parts[COMPLAINT]]
    for name in ("stage", "stage_second"):
        parts[name].stop(stopping, parts["reading"], shown, queue=False, **QUIET)


def _connect_saving(gr: Any, parts: dict[str, Any]) -> None:
    def save(shown: Any, event: Any) -> Iterator[Filled]:
        yield {"saving": opening.saved(str(event._data.get("kind")), shown)}

    parts["saving"].click(
        filling(parts, save, gr.EventData),
        [parts["shown"]],
        [parts["saving"], parts[COMPLAINT]],
        **PRIVATE,
    )
