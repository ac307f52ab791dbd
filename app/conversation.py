"""A conversation as the page lays it out: messages, questions to try, the line to type in."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

from geotlm_lm import FrameSpec

from . import handlers, suggestions
from .error_display import MODEL, gradio
from .facts import MIRRORED, OTHER_SIDE, SENSOR_MOVES, TURNS, update_facts
from .filling import COMPLAINT, Filled, complaint, filling
from .limits import QUESTION_CHARACTERS

PLACEHOLDER = "Ask how the touched object moves, in plain English, or click a question below."

PRIVATE = {"api_visibility": "private"}


class Talk(Protocol):
    """What answers the questions of a page; each method takes the context last."""

    def ask(self, question: str, chat: list, *context: Any) -> Iterator[Filled]:
        """Yield what the parts show while a question is answered."""

    def again(self, chat: list, *context: Any) -> Iterator[Filled]:
        """Ask the last question again, likewise."""

    def forget(self, *context: Any) -> Iterator[Filled]:
        """Begin anew."""


def talk() -> dict[str, Any]:
    """Lay out the conversation."""
    gr, parts = gradio(), {}
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


def frame_of_reference() -> dict[str, Any]:
    """Lay out the facts that directions and lengths are told by."""
    gr, parts = gradio(), {}
    gr.Markdown(
        "Directions are told **as seen in the camera image** (looking out of the sensor at the "
        "object), for the object relative to the sensor. Check what is different about yours."
    )
    with gr.Row():
        parts["frame"] = gr.CheckboxGroup(
            [MIRRORED, *TURNS, OTHER_SIDE, SENSOR_MOVES], label="Tell it for another frame"
        )
        parts["mm_per_px"] = gr.Number(
            label="Millimetres per pixel (0: slides are told in pixels)", value=0, step=0.01
        )
    parts["told"] = gr.Markdown(handlers.direction_in_frame(FrameSpec(), None))
    return parts


def connect(
    parts: dict[str, Any], to: Talk, context: Sequence[str], answered: Sequence[str]
) -> None:
    """Connect the conversation, and the facts beside it.

    Args:
        parts: The tab's, by name.
        to: What answers.
        context: Names of the parts that it is given beside question and conversation; the page's
            address comes last of all.
        answered: Names of the parts that it fills.
    """
    gr = gradio()

    def ask(*given: Any) -> Iterator[Filled]:
        yield from to.ask(*given[:-1], address_of(given[-1]))

    def ask_again(*given: Any) -> Iterator[Filled]:
        yield from to.again(*given[:-1], address_of(given[-1]))

    names = ("question", "chat", *context)
    asked, outputs = [parts[name] for name in names], [parts[name] for name in answered]
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
    # All that is filled with an answer is emptied, but for what is typed.
    forgotten = [parts[name] for name in (*answered, "shown") if name in parts]
    parts["chat"].clear(
        filling(parts, to.forget),
        asked[2:],
        forgotten,
        cancels=running,
        show_progress="hidden",
        **PRIVATE,
    )
    _connect_frame(gr, parts)


def address_of(request: Any) -> str:
    """Return the address that a visitor's browser has for the page."""
    return f"http://{request.headers.get('host', '127.0.0.1:7860')}"


def _connect_frame(gr: Any, parts: dict[str, Any]) -> None:
    def check(facts: list[str], direction: str | None, event: gr.SelectData) -> tuple:
        held, told = update_facts(facts, direction, event.value, event.selected)
        # Boxes that stand as they should are left alone: others may be checked meanwhile.
        return gr.skip() if set(held) == set(facts) else held, told

    # Postponed annotations are text, and the toolkit looks for the event's type itself.
    check.__annotations__["event"] = gr.SelectData
    outputs = [parts[name] for name in ("frame", "told")]
    parts["frame"].select(check, [parts["frame"], parts["last"]], outputs, **PRIVATE)
