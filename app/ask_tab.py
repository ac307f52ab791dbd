"""The Ask tab: the stage and its timeline on the left, the conversation on the right."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from . import conversation, opening, stage
from .clips import SUFFIXES
from .guards import TOPIC_CHARACTERS
from .opening import NOTHING_ASKED, Opening
from .talking import Talking
from .toolkit import COMPLAINT, MODEL, PRIVATE, QUIET, Filled, filling, gradio

if TYPE_CHECKING:
    from geotlm_lm import Answerer

CONTEXT = ("shown", "source", "frame", "mm_per_px")
"""What questions are about."""

ANSWERED = (
    *NOTHING_ASKED,
    *("question", "frame", "mm_per_px", "framed", "chips", "saving", "stage", COMPLAINT),
)
"""What is filled when a question is answered."""

OPENED = (
    *(name for name in ANSWERED if name not in ("question", "frame")),
    *("shown", "source", "clip_notes", "first", "last_frame", "topic", "files"),
)
"""What is filled when a recording is opened or closed."""


def build(answerer: Answerer, page: Any) -> None:
    """Lay the tab out and connect it; an example is opened with the page (a `gradio.Blocks`)."""
    gr = gradio()
    parts: dict[str, Any] = {name: gr.State() for name in ("shown", "source", "last")}
    with gr.Row(elem_classes=["ask"]):
        with gr.Column(scale=11, min_width=320, elem_classes=["ask-stage"]):
            parts["stage"] = stage.build()
        with gr.Column(scale=9, min_width=320, elem_classes=["ask-talk"]):
            parts |= conversation.talk()
    with gr.Row(elem_classes=["open-another"]):
        parts["files"] = gr.File(
            label="Recording or images",
            file_types=SUFFIXES,
            file_count="multiple",
            type="filepath",
            height=96,
            elem_classes=["drop"],
            scale=2,
            min_width=240,
        )
        with gr.Column(scale=7, min_width=300):
            parts["examples"] = opening.strip()
    parts |= _below(gr)
    talking = Talking(answerer)
    _connect_opening(gr, parts, Opening(answerer), talking, page)
    conversation.connect(parts, talking, CONTEXT, ANSWERED)
    # Lengths are in mm, or in pixels again, as soon as the field of the pixel's size is left.
    given = [parts[name] for name in ("shown", "source", "mm_per_px")]
    resized = [parts[name] for name in ("stage", "chips", COMPLAINT)]
    for trigger in (parts["mm_per_px"].submit, parts["mm_per_px"].blur):
        trigger(filling(parts, talking.resize), given, resized, **QUIET, **MODEL)
    _connect_saving(gr, parts)


def _below(gr: Any) -> dict[str, Any]:
    """Lay out what a first look does without, closed."""
    parts: dict[str, Any] = {}
    with gr.Accordion("Evidence: probabilities, other methods, regions", open=False):
        parts["notes"] = gr.Markdown()
        with gr.Row():
            parts["probabilities"] = gr.Label(label="Calibrated probabilities", num_top_classes=5)
            parts["verdicts"] = gr.Dataframe(
                headers=["read by", "motion", "how"],
                label="Read by three methods",
                interactive=False,
                wrap=True,
            )
        parts["band"] = gr.Markdown()
        parts["regions"] = gr.Dataframe(
            headers=["region", "shear change x", "shear change y", "contact mass"],
            label="Seven regions",
            interactive=False,
        )
        parts["timing"] = gr.Markdown()
    with gr.Accordion("Frame of reference", open=False):
        parts |= conversation.frame_of_reference()
    with gr.Accordion("Frames and notes", open=False):
        with gr.Row():
            # Text: of a number field left empty the page makes 0, which is a frame.
            parts["first"] = gr.Textbox(label="First frame (empty: all)", max_length=9)
            parts["last_frame"] = gr.Textbox(label="Last frame", max_length=9)
            parts["topic"] = gr.Textbox(
                label="Topic of a bag (empty: its only one)", max_length=TOPIC_CHARACTERS
            )
        parts["read"] = gr.Button("Read again with these")
        parts["clip_notes"] = gr.Markdown()
    with gr.Accordion("Copy this as code", open=False):
        parts["code"] = gr.Code(
            label="The conversation in Python",
            language="python",
            interactive=False,
            buttons=["copy"],
        )
    with gr.Accordion("Save and share", open=False):
        parts["saving"] = opening.saving_bar()
    return parts


def _connect_opening(
    gr: Any, parts: dict[str, Any], opens: Opening, talking: Talking, page: Any
) -> None:
    before = [parts[name] for name in ("frame", "mm_per_px", "shown")]
    outputs = [parts[name] for name in OPENED]
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

    def visit(request: Any) -> Iterator[Filled]:
        yield from opens.visit(request.query_params)

    def ask_if_linked(question: str, *given: Any) -> Iterator[Filled]:
        if question:
            yield from talking.ask(question, *given)

    page.load(
        filling(parts, visit, gr.Request),
        None,
        [parts[name] for name in ("stage", "source", "question", COMPLAINT)],
        queue=False,
        **PRIVATE,
    ).then(again, [*spanned, *before], outputs, **at_stage).then(
        filling(parts, ask_if_linked),
        [parts[name] for name in ("question", "chat", *CONTEXT)],
        [parts[name] for name in ANSWERED],
        **at_stage,
    )


def _connect_saving(gr: Any, parts: dict[str, Any]) -> None:
    def save(shown: Any, source: Any, event: Any) -> Iterator[Filled]:
        yield {"saving": opening.saved(str(event._data.get("kind")), shown, source)}

    parts["saving"].click(
        filling(parts, save, gr.EventData),
        [parts["shown"], parts["source"]],
        [parts["saving"], parts[COMPLAINT]],
        **PRIVATE,
    )
