"""The Ask tab: a clip and what the model sees in it on the left, the conversation on the right."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, Motion, draw_viewpoint

from . import handlers
from .playing import add_play_button
from .told import MODEL, gradio, told

if TYPE_CHECKING:
    from geotlm_lm import Answerer

SUFFIXES = [".npy", ".npz", ".mp4", ".avi", ".mov", ".mkv", ".png", ".jpg", ".jpeg", ".bmp"]
VIEWS = ["raw", "difference", "contact", "arrows"]
MIRRORED, UPSIDE_DOWN = "image is mirrored", "image is upside down"
CLOCKWISE = "image is turned 90° clockwise"
COUNTERCLOCKWISE = "image is turned 90° counterclockwise"
TURNS = {UPSIDE_DOWN: 180, CLOCKWISE: 90, COUNTERCLOCKWISE: 270}
OTHER_SIDE, SENSOR_MOVES = "seen from the object", "sensor moves"

BUTTONS = ["download", "fullscreen"]
"""Beside a picture; the toolkit's third shares it with a site on the network."""

ANSWER_PARTS = ("probabilities", "band", "verdicts", "regions", "timing", "details")
"""What stands beside an answer's words, in the order `_answer` yields it."""

Messages = list[dict[str, Any]]


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    shown, last = gr.State(), gr.State()
    with gr.Row():
        with gr.Column():
            clip = _clip_side(gr)
        with gr.Column():
            talk = _talk_side(gr)
    _connect_clip(answerer, shown, last, clip, talk)
    _connect_talk(answerer, shown, last, clip, talk)


def _clip_side(gr: Any) -> dict[str, Any]:
    side = {}
    side["path"] = gr.File(
        label="Recording (or several images of one)",
        file_types=SUFFIXES,
        file_count="multiple",
        type="filepath",
        height=120,
    )
    side["gallery"] = gr.Gallery(
        _thumbnails(),
        label="Examples: click one",
        columns=4,
        height=300,
        allow_preview=False,
        interactive=False,
        buttons=[],
    )
    with gr.Row():
        side["view"] = gr.Radio(VIEWS, value="arrows", label="View")
        with gr.Column():
            side["number"] = gr.Slider(1, 4, value=4, step=1, label="Frame (of four)")
            add_play_button(gr, side["number"])
    side["picture"] = gr.Image(label="What the model sees", interactive=False, buttons=BUTTONS)
    with gr.Accordion("Frame of reference", open=True), gr.Row():
        side["viewpoint"] = gr.Image(
            draw_viewpoint(FrameSpec()),
            show_label=False,
            interactive=False,
            height=150,
            buttons=[],
        )
        side["frame"] = gr.CheckboxGroup(
            [MIRRORED, *TURNS, OTHER_SIDE, SENSOR_MOVES], label="Tell it for another frame"
        )
        side["mm_per_px"] = gr.Number(
            label="Millimetres per pixel (0: slides are told in pixels)", value=0, step=0.01
        )
    side["told"] = gr.Markdown(handlers.told_in(FrameSpec(), None))
    with gr.Accordion("Frames and notes", open=False):
        with gr.Row():
            side["first"] = gr.Number(label="First frame (empty: chosen)", precision=0, value=None)
            side["last"] = gr.Number(label="Last frame", precision=0, value=None)
        side["read"] = gr.Button("Read again with this span")
        side["notes"] = gr.Markdown()
    return side


def _talk_side(gr: Any) -> dict[str, Any]:
    side = {}
    side["chat"] = gr.Chatbot(label="Conversation", height=300, buttons=["copy", "copy_all"])
    side["question"] = gr.Textbox(
        label="Question", value=handlers.EXAMPLE_QUESTIONS[0], max_length=500
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


def _connect_clip(answerer: Answerer, shown: Any, last: Any, clip: dict, talk: dict) -> None:
    gr = gradio()
    pictured = [shown, clip["view"], clip["number"]]
    # What was said of the clip before must not stand beside the new one.
    stale = [*(talk[name] for name in ANSWER_PARTS), last]
    pixel = clip["mm_per_px"]
    outputs = [shown, clip["picture"], clip["notes"], clip["told"], pixel, talk["chat"], *stale]

    def open_clip(
        path: Any, first: Any, until: Any, view: str, number: float, *known: Any
    ) -> tuple:
        facts, mm_per_px, before = known
        # Of a number left empty the page makes 0 once it was shown, and from 0 to 0 is no span.
        span = (first, until) if first or until else (None, None)
        opened = handlers.show_clip(answerer, path, *span)
        drawn = handlers.draw(opened, view, number)
        _, told_anew = _frame(facts, None)
        if before is not None and _size(before) != _size(opened):
            mm_per_px = 0  # what was said of other pixels
        return opened, drawn, opened.notes, told_anew, mm_per_px, [], *[None] * len(stale)

    def open_example(
        view: str, number: float, facts: list[str], size: float, before: Any, event: gr.SelectData
    ) -> tuple:
        path = handlers.EXAMPLE_CLIPS[event.index]
        return open_clip(path, None, None, view, number, facts, size, before)

    # Postponed annotations are text, and the toolkit looks for the event's type itself.
    open_example.__annotations__["event"] = gr.SelectData
    looked_at = [*(clip[name] for name in ("view", "number", "frame")), pixel, shown]
    given = [*(clip[name] for name in ("path", "first", "last")), *looked_at]
    private = {"api_visibility": "private"}
    for trigger in (clip["path"].upload, clip["read"].click):
        trigger(told(open_clip), given, outputs, **private, **MODEL)
    clip["gallery"].select(told(open_example), looked_at, outputs, **private, **MODEL)
    for control in (clip["view"], clip["number"]):
        control.change(handlers.draw, pictured, clip["picture"], **private)


def _size(shown: Any) -> tuple[int, int]:
    return shown.encoded.clip.frames.shape[1:3]


def _connect_talk(answerer: Answerer, shown: Any, last: Any, clip: dict, talk: dict) -> None:
    answer = told(partial(_answer, answerer))
    again = told(partial(_retry, answerer))
    framed = [clip["viewpoint"], clip["told"]]
    stated = [clip["frame"], clip["mm_per_px"]]
    beside = [*(talk[name] for name in ANSWER_PARTS), last, *stated, *framed]
    outputs = [talk["chat"], talk["question"], *beside]
    private = {"api_visibility": "private"}
    asked = [shown, talk["question"], talk["chat"], *stated]
    running = [
        trigger(answer, asked, outputs, **private, **MODEL)
        for trigger in (talk["ask"].click, talk["question"].submit)
    ]
    running.append(talk["retry"].click(again, asked, outputs, **private, **MODEL))
    talk["stop"].click(None, None, None, cancels=running, api_visibility="private")
    talk["suggested"].input(lambda text: text or "", talk["suggested"], talk["question"], **private)
    clip["frame"].input(_frame, [clip["frame"], last], framed, **private)


def _answer(
    answerer: Answerer,
    shown: Any,
    question: str,
    chat: Messages,
    facts: list[str],
    mm_per_px: float | None,
) -> Iterator[tuple]:
    """Yield the conversation as words are generated, and with the last all that stands beside."""
    before = [*(chat or []), {"role": "user", "content": question}]
    skip, said = gradio().skip(), ""
    field = ""  # emptied once: what is typed meanwhile is the next question
    fields = _fields(facts) | {"mm_per_px": mm_per_px or None}
    for told_so_far in handlers.converse(answerer, shown, question, fields):
        if isinstance(told_so_far, str):
            said += told_so_far
            yield [*before, {"role": "assistant", "content": said}], field, *[skip] * 11
            field = skip
        else:
            reply = told_so_far
    frame = shown.session.frame
    stated = _facts(frame)
    direction = None if reply.motion is None else reply.motion.value
    yield (
        [*before, {"role": "assistant", "content": reply.sentence}],
        field,
        reply.probabilities,
        reply.band,
        reply.verdicts,
        reply.regions,
        reply.timing,
        reply.details,
        direction,
        stated,
        frame.mm_per_px or 0,
        *_frame(stated, direction),
    )


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


def _text(message: dict[str, Any]) -> str:
    """Return a message's words; the toolkit hands them back as a list of blocks."""
    content = message["content"]
    if isinstance(content, str):
        return content
    return " ".join(block.get("text", "") for block in content if isinstance(block, dict))


def _fields(facts: list[str]) -> dict[str, Any]:
    """Return the fields of a `FrameSpec` that the checked facts stand for; turns add up."""
    turned = sum(degrees for fact, degrees in TURNS.items() if fact in facts)
    return FrameSpec.fields_of_turn(turned) | {
        "image_mirrored": MIRRORED in facts,
        "viewpoint": "object" if OTHER_SIDE in facts else "sensor",
        "actor": "sensor" if SENSOR_MOVES in facts else "object",
    }


def _facts(frame: FrameSpec) -> list[str]:
    """Return the facts to check for a frame: what the conversation said of it shows in the page."""
    is_so = {
        MIRRORED: frame.image_mirrored,
        UPSIDE_DOWN: frame.image_upside_down,
        CLOCKWISE: frame.image_quarter_turn == "clockwise",
        COUNTERCLOCKWISE: frame.image_quarter_turn == "counterclockwise",
        OTHER_SIDE: frame.viewpoint == "object",
        SENSOR_MOVES: frame.actor == "sensor",
    }
    return [fact for fact, is_true in is_so.items() if is_true]


def _frame(facts: list[str], direction: str | None) -> tuple:
    frame = FrameSpec(**_fields(facts))
    motion = None if direction is None else Motion(direction)
    return draw_viewpoint(frame), handlers.told_in(frame, motion)


def _thumbnails() -> list[tuple[Any, str]]:
    from geotlm_lm import read_clip

    return [
        (read_clip(path).frames[-1], _caption(Path(path).stem)) for path in handlers.EXAMPLE_CLIPS
    ]


_HARD = {
    "can_rim_clockwise": "a thin edge",
    "textured_ball_release": "a ball",
    "corner_counterclockwise": "at the border",
    "key_none": "no contact",
    "pen_clip_left": "a small slide",
}


def _caption(name: str) -> str:
    hard = f" (hard: {_HARD[name]})" if name in _HARD else ""
    return name.replace("_", " ") + hard
