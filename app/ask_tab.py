"""The Ask tab: a clip and what the model sees in it on the left, the conversation on the right."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from html import escape, unescape
from typing import TYPE_CHECKING, Any

from . import clip_side, handlers
from .error_display import gradio, literal, model_at, with_errors_shown
from .facts import facts_of, fields_of, frame_preview, update_facts
from .limits import QUESTION_CHARACTERS

if TYPE_CHECKING:
    from geotlm_lm import Answerer

ANSWER_PARTS = ("notes", "probabilities", "band", "verdicts", "regions", "timing", "details")
"""What stands beside an answer's words, in the order `_answer` yields it."""

FRAME_PARTS = ("frame", "mm_per_px", "viewpoint", "told")
"""What the other side shows of the frame of reference, yielded after the motion that was told."""

Messages = list[dict[str, Any]]


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    shown, last = gr.State(), gr.State()
    with gr.Row():
        with gr.Column():
            clip = clip_side.build(gr)
        with gr.Column():
            talk = _talk_side(gr)
    # What was said of the clip before must not stand beside the new one.
    stale = [talk["chat"], *(talk[name] for name in ANSWER_PARTS), last]
    clip_side.connect(answerer, shown, clip, stale)
    _connect_talk(answerer, shown, last, clip, talk, stale)


def _talk_side(gr: Any) -> dict[str, Any]:
    side = {}
    side["chat"] = gr.Chatbot(
        label="Conversation",
        height=300,
        buttons=["copy", "copy_all"],
        # A question is shown as it was typed: a picture in it would be fetched from its site.
        # Without Markdown the toolkit still takes a message for HTML.
        render_markdown=False,
    )
    side["notes"] = gr.Markdown()
    side["question"] = gr.Textbox(
        label="Question",
        value=handlers.EXAMPLE_QUESTIONS[0],
        max_length=QUESTION_CHARACTERS,
    )
    with gr.Row():
        side["ask"] = gr.Button("Ask", variant="primary")
        side["stop"] = gr.Button("Stop")
        side["retry"] = gr.Button("Retry")
    side["suggested"] = gr.Dropdown(
        [(f"{kind}: {text}", text) for kind, text in handlers.SUGGESTED_QUESTIONS.items()],
        label="Questions by type",
        value=None,
    )
    side["probabilities"] = gr.Label(label="Calibrated probabilities", num_top_classes=5)
    side["band"] = gr.Markdown()
    side["verdicts"] = gr.Dataframe(
        headers=["read by", "motion", "how"],
        label="Verdicts side by side",
        interactive=False,
        wrap=True,
    )
    with gr.Accordion("Evidence: seven regions", open=True):
        side["regions"] = gr.Dataframe(
            headers=["region", "shear change x", "shear change y", "contact mass"],
            interactive=False,
        )
    side["timing"] = gr.Markdown()
    with gr.Accordion("Everything the answer rests on", open=False):
        side["details"] = gr.JSON()
    return side


def _connect_talk(
    answerer: Answerer, shown: Any, last: Any, clip: dict, talk: dict, stale: list[Any]
) -> None:
    gr = gradio()
    answer = with_errors_shown(partial(_answer, answerer))
    again = with_errors_shown(partial(_retry, answerer))
    stated, framed = [clip[one] for one in FRAME_PARTS[:2]], [clip[one] for one in FRAME_PARTS[2:]]
    beside = [*(talk[name] for name in ANSWER_PARTS), last, *stated, *framed]
    outputs = [talk["chat"], talk["question"], *beside]
    private, at_chat = {"api_visibility": "private"}, model_at(talk["chat"])
    asked = [shown, talk["question"], talk["chat"], *stated]
    running = [
        trigger(answer, asked, outputs, **at_chat)
        for trigger in (talk["ask"].click, talk["question"].submit)
    ]
    running.append(talk["retry"].click(again, asked, outputs, **at_chat))
    talk["stop"].click(None, None, None, cancels=running, api_visibility="private")
    talk["chat"].clear(
        partial(_forget, answerer, len(stale) - 1),
        [shown, clip["frame"]],
        [shown, clip["told"], *stale],
        cancels=running,
        **private,
    )
    talk["suggested"].input(lambda text: text or "", talk["suggested"], talk["question"], **private)

    def check(facts: list[str], direction: str | None, event: gr.SelectData) -> tuple:
        held, *framing = update_facts(facts, direction, event.value, event.selected)
        # Boxes that stand as they should are left alone: others may be checked meanwhile.
        return gr.skip() if set(held) == set(facts) else held, *framing

    # Postponed annotations are text, and the toolkit looks for the event's type itself.
    check.__annotations__["event"] = gr.SelectData
    clip["frame"].select(check, [clip["frame"], last], [clip["frame"], *framed], **private)


def _answer(
    answerer: Answerer,
    shown: Any,
    question: str,
    chat: Messages,
    facts: list[str],
    mm_per_px: float | None,
) -> Iterator[tuple]:
    """Yield the conversation word by word, and with the last all that stands beside."""
    before = [*(chat or []), _message("user", question)]
    skip, said = gradio().skip(), ""
    field = ""  # emptied once: what is typed meanwhile is the next question
    fields = fields_of(facts) | {"mm_per_px": mm_per_px or None}
    for told_so_far in handlers.converse(answerer, shown, question, fields):
        if isinstance(told_so_far, str):
            said += told_so_far
            beside = [skip] * len((*ANSWER_PARTS, "motion", *FRAME_PARTS))
            yield [*before, _message("assistant", said)], field, *beside
            field = skip
        else:
            reply = told_so_far
    frame = shown.session.frame
    stated = facts_of(frame)
    direction = None if reply.motion is None else reply.motion.value
    yield (
        [*before, _message("assistant", reply.sentence)],
        field,
        literal(reply.notes),
        reply.probabilities,
        reply.band,
        reply.verdicts,
        reply.regions,
        reply.timing,
        reply.details,
        direction,
        stated,
        frame.mm_per_px or 0,
        *frame_preview(stated, direction),
    )


def _forget(answerer: Answerer, others: int, shown: Any, facts: list[str]) -> tuple:
    """Begin the conversation about the clip anew; the frame that the page shows still holds.

    Args:
        answerer: The model.
        others: How many parts beside the conversation are emptied.
        shown: The clip; None when no clip is open.
        facts: That are checked.
    """
    anew = None if shown is None else replace(shown, session=answerer.session(shown.encoded))
    return anew, frame_preview(facts, None)[1], [], *[None] * others


def _retry(
    answerer: Answerer, shown: Any, question: str, chat: Messages, *stated: Any
) -> Iterator[tuple]:
    """Ask the last question of the conversation again, in its old place."""
    asked = [place for place, one in enumerate(chat or []) if one["role"] == "user"]
    if asked:
        question, chat = _text(chat[asked[-1]]), chat[: asked[-1]]
        if shown is not None:
            shown.session.take_back(question)
    yield from _answer(answerer, shown, question, chat, *stated)


def _message(role: str, text: str) -> dict[str, Any]:
    """Return a message that the conversation shows as it is."""
    return {"role": role, "content": escape(text, quote=False)}


def _text(message: dict[str, Any]) -> str:
    """Return a message's words; the toolkit hands them back as a list of blocks."""
    content = message["content"]
    if isinstance(content, str):
        return unescape(content)
    return unescape(" ".join(block.get("text", "") for block in content if isinstance(block, dict)))
