"""The Ask tab: the stage and its timeline on the left, the conversation on the right."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, draw_viewpoint

from . import example_clips, handlers, saving, stage, suggestions
from .clip_loading import SUFFIXES
from .error_display import MODEL, gradio
from .facts import MIRRORED, OTHER_SIDE, SENSOR_MOVES, TURNS, update_facts
from .filling import COMPLAINT, Filled, complaint, filling
from .limits import QUESTION_CHARACTERS
from .opening import NOTHING_SAID, Opening
from .talking import Talking

if TYPE_CHECKING:
    from geotlm_lm import Answerer

PLACEHOLDER = "Ask how the touched object moves, in plain English, or click a question below."

PRIVATE = {"api_visibility": "private"}

OPENED = (
    *NOTHING_SAID,
    *("shown", "source", "stage", "clip_notes", "told", "mm_per_px", "chips", "saving"),
    *("first", "last_frame", "files", COMPLAINT),
)
"""What is filled when a recording is opened or closed."""

ANSWERED = (
    *NOTHING_SAID,
    *("question", "frame", "mm_per_px", "viewpoint", "told", "chips", "saving", "stage"),
    COMPLAINT,
)
"""What is filled when a question is answered."""


def build(answerer: Answerer, page: Any) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`.

    Args:
        answerer: The model.
        page: The `gradio.Blocks`; an example is opened with it.
    """
    gr = gradio()
    parts: dict[str, Any] = {name: gr.State() for name in ("shown", "source", "last")}
    with gr.Row(elem_classes=["ask"]):
        with gr.Column(scale=11, min_width=320, elem_classes=["ask-stage"]):
            parts["stage"] = stage.build()
        with gr.Column(scale=9, min_width=320, elem_classes=["ask-talk"]):
            parts |= _talk(gr)
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
            parts["examples"] = example_clips.strip()
    parts |= _below(gr)
    _connect_opening(gr, parts, Opening(answerer), Talking(answerer), page)
    _connect_talk(gr, parts, Talking(answerer))


def _talk(gr: Any) -> dict[str, Any]:
    parts = {}
    parts["chat"] = gr.Chatbot(
        label="Conversation",
        elem_classes=["chat"],
        height="100%",
        buttons=["copy_all"],
        placeholder=PLACEHOLDER,
        # A question is shown as it was typed: a picture in it would be fetched from its site.
        # Without Markdown the toolkit still takes a message for HTML.
        render_markdown=False,
    )
    parts["chips"] = suggestions.chips()
    with gr.Row(elem_classes=["ask-line"]):
        parts["question"] = gr.Textbox(
            label="Question",
            show_label=False,
            container=False,
            placeholder="Your question",
            max_length=QUESTION_CHARACTERS,
            scale=6,
            min_width=160,
            elem_classes=["question"],
        )
        parts["ask"] = gr.Button("Ask", variant="primary", scale=1, min_width=64)
        parts["stop"] = gr.Button("Stop", scale=1, min_width=56)
        parts["retry"] = gr.Button("Retry", scale=1, min_width=56)
    parts[COMPLAINT] = complaint()
    return parts


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
        parts |= _frame_of_reference(gr)
    with gr.Accordion("Frames and notes", open=False):
        with gr.Row():
            # Text: of a number field left empty the page makes 0, which is a frame.
            parts["first"] = gr.Textbox(label="First frame (empty: all)", max_length=9)
            parts["last_frame"] = gr.Textbox(label="Last frame", max_length=9)
        parts["read"] = gr.Button("Read again with this span")
        parts["clip_notes"] = gr.Markdown()
    with gr.Accordion("Copy this as code", open=False):
        gr.Markdown("The last question, for the shell, for Python and over REST.")
        for name, label, language in (
            ("command", "Command line", "shell"),
            ("python", "Python", "python"),
            ("rest", "REST", "shell"),
        ):
            parts[name] = gr.Code(
                label=label, language=language, interactive=False, buttons=["copy"]
            )
    with gr.Accordion("Save and share", open=False):
        parts["saving"] = saving.bar()
    return parts


def _frame_of_reference(gr: Any) -> dict[str, Any]:
    parts = {}
    gr.Markdown(
        "Directions are told **as seen in the camera image** (looking out of the sensor at the "
        "object), for the object relative to the sensor. Check what is different about yours."
    )
    with gr.Row():
        parts["viewpoint"] = gr.Image(
            draw_viewpoint(FrameSpec()),
            label="Where the camera stands",
            show_label=False,
            interactive=False,
            height=150,
            buttons=[],
        )
        parts["frame"] = gr.CheckboxGroup(
            [MIRRORED, *TURNS, OTHER_SIDE, SENSOR_MOVES], label="Tell it for another frame"
        )
        parts["mm_per_px"] = gr.Number(
            label="Millimetres per pixel (0: slides are told in pixels)", value=0, step=0.01
        )
    parts["told"] = gr.Markdown(handlers.direction_in_frame(FrameSpec(), None))
    return parts


def _connect_opening(
    gr: Any, parts: dict[str, Any], opening: Opening, talking: Talking, page: Any
) -> None:
    before = [parts[name] for name in ("frame", "mm_per_px", "shown")]
    outputs = [parts[name] for name in OPENED]
    at_stage = {**PRIVATE, "show_progress": "hidden", **MODEL}
    files, upload = parts["files"], filling(parts, opening.upload)
    for trigger in (files.upload, files.clear, files.delete):
        trigger(upload, [files, *before], outputs, **at_stage)

    def open_example(*given: Any) -> Iterator[Filled]:
        *now, event = given
        yield from opening.example(str(event._data.get("example")), *now)

    clicked = filling(parts, open_example, gr.EventData)
    parts["examples"].click(clicked, before, outputs, **at_stage)
    spanned = [parts[name] for name in ("source", "first", "last_frame")]
    again = filling(parts, opening.read_again)
    parts["read"].click(again, [*spanned, *before], outputs, **at_stage)

    def visit(request: Any) -> Iterator[Filled]:
        yield from opening.visit(request.query_params)

    visited = page.load(
        filling(parts, visit, gr.Request),
        None,
        [parts[name] for name in ("stage", "source", "question", COMPLAINT)],
        queue=False,
        **PRIVATE,
    ).then(again, [*spanned, *before], outputs, **at_stage)

    def ask_if_linked(question: str, *given: Any) -> Iterator[Filled]:
        if question:
            yield from talking.ask(question, *given[:-1], _address(given[-1]))

    visited.then(
        filling(parts, ask_if_linked, gr.Request),
        _asked(parts),
        [parts[name] for name in ANSWERED],
        **at_stage,
    )


def _asked(parts: dict[str, Any]) -> list[Any]:
    names = ("question", "chat", "shown", "source", "frame", "mm_per_px")
    return [parts[name] for name in names]


def _address(request: Any) -> str:
    return f"http://{request.headers.get('host', '127.0.0.1:7860')}"


def _connect_talk(gr: Any, parts: dict[str, Any], talking: Talking) -> None:
    def ask(*given: Any) -> Iterator[Filled]:
        yield from talking.ask(*given[:-1], _address(given[-1]))

    def ask_again(*given: Any) -> Iterator[Filled]:
        yield from talking.again(*given[:-1], _address(given[-1]))

    asked, outputs = _asked(parts), [parts[name] for name in ANSWERED]
    options = {**PRIVATE, "show_progress_on": [parts["chips"]], **MODEL}
    asking = filling(parts, ask, gr.Request)
    running = [
        trigger(asking, asked, outputs, **options)
        for trigger in (parts["ask"].click, parts["question"].submit)
    ]
    again = filling(parts, ask_again, gr.Request)
    running.append(parts["retry"].click(again, asked[1:], outputs, **options))

    def take(event: Any) -> Iterator[Filled]:
        yield {"question": str(event._data.get("text", ""))[:QUESTION_CHARACTERS]}

    chosen = parts["chips"].click(
        filling(parts, take, gr.EventData),
        None,
        [parts["question"], parts[COMPLAINT]],
        queue=False,
        **PRIVATE,
    )
    running.append(chosen.then(asking, asked, outputs, **options))
    parts["stop"].click(None, None, None, cancels=running, **PRIVATE)
    parts["chat"].clear(
        filling(parts, talking.forget),
        [parts[name] for name in ("shown", "source", "frame")],
        [*(parts[name] for name in (*NOTHING_SAID, "shown", "told", "chips", "saving", COMPLAINT))],
        cancels=running,
        **PRIVATE,
    )
    _connect_frame(gr, parts)
    _connect_saving(gr, parts)


def _connect_frame(gr: Any, parts: dict[str, Any]) -> None:
    def check(facts: list[str], direction: str | None, event: gr.SelectData) -> tuple:
        held, *framing = update_facts(facts, direction, event.value, event.selected)
        # Boxes that stand as they should are left alone: others may be checked meanwhile.
        return gr.skip() if set(held) == set(facts) else held, *framing

    # Postponed annotations are text, and the toolkit looks for the event's type itself.
    check.__annotations__["event"] = gr.SelectData
    outputs = [parts[name] for name in ("frame", "viewpoint", "told")]
    parts["frame"].select(check, [parts["frame"], parts["last"]], outputs, **PRIVATE)


def _connect_saving(gr: Any, parts: dict[str, Any]) -> None:
    def save(shown: Any, source: Any, event: Any) -> Iterator[Filled]:
        name, example = (source.name, source.example) if source else ("", None)
        kind = str(event._data.get("kind"))
        yield {"saving": saving.saved(kind, shown, name, example)}

    parts["saving"].click(
        filling(parts, save, gr.EventData),
        [parts["shown"], parts["source"]],
        [parts["saving"], parts[COMPLAINT]],
        **PRIVATE,
    )
