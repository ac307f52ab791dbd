"""The left side of the Ask tab: the clip that is open, and what the model sees in it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, draw_viewpoint

from . import handlers
from .clip_loading import SUFFIXES, latest_upload, load_clip
from .error_display import gradio, literal, model_at, with_errors_shown
from .facts import MIRRORED, OTHER_SIDE, SENSOR_MOVES, TURNS, frame_preview
from .play_button import add_play_button

if TYPE_CHECKING:
    from geotlm_lm import Answerer

VIEWS = ["raw", "difference", "contact", "arrows"]

BUTTONS = ["download", "fullscreen"]
"""Beside a picture; the toolkit's third shares it with a site on the network."""


def build(gr: Any) -> dict[str, Any]:
    """Lay the side out and return its parts by name."""
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
    side["told"] = gr.Markdown(handlers.direction_in_frame(FrameSpec(), None))
    with gr.Accordion("Frames and notes", open=False):
        with gr.Row():
            # Text: of a number field left empty the page makes 0, which is a frame.
            side["first"] = gr.Textbox(label="First frame (empty: chosen)", max_length=9)
            side["last"] = gr.Textbox(label="Last frame", max_length=9)
        side["read"] = gr.Button("Read again with this span")
        side["notes"] = gr.Markdown()
    return side


def connect(answerer: Answerer, shown: Any, clip: dict[str, Any], stale: list[Any]) -> None:
    """Connect the side's parts to what they do.

    Args:
        answerer: The model.
        shown: The state that holds the clip that is open.
        clip: The side's parts.
        stale: The conversation, and what else was said of the clip before: emptied with it.
    """
    gr = gradio()
    source = gr.State()
    pixel, span = clip["mm_per_px"], [clip["first"], clip["last"]]
    outputs = [shown, source, clip["picture"], clip["notes"], clip["told"], pixel, *stale]
    looked_at = [*(clip[name] for name in ("view", "number", "frame")), pixel, shown]
    nothing = [[], *[None] * (len(stale) - 1)]

    def read_again(path: Any, first: str, until: str, *looked: Any) -> Iterator[tuple]:
        # A mistake is told only after the clip before is closed: it must not answer for this one.
        try:
            opened = load_clip(answerer, path, first, until)
        except Exception:
            yield *_closed(path, *looked), *nothing
            raise
        yield *_opened(opened, path, *looked), *nothing

    def open_clip(paths: list[str] | None, *looked: Any) -> Iterator[tuple]:
        given = latest_upload(paths)
        box = gr.skip() if given == paths else given
        for step in read_again(given, "", "", *looked):
            yield *step, box, "", ""

    def take_away(paths: list[str] | None, *looked: Any) -> Iterator[tuple]:
        if paths:
            yield from open_clip(paths, *looked)
        else:
            yield *_closed(None, *looked), *nothing, None, "", ""

    def open_example(
        view: str, number: float, facts: list[str], size: float, before: Any, event: gr.SelectData
    ) -> Iterator[tuple]:
        path = handlers.EXAMPLE_CLIPS[event.index]
        for step in read_again(path, "", "", view, number, facts, size, before):
            yield *step, None, "", ""

    # Postponed annotations are text, and the toolkit looks for the event's type itself.
    open_example.__annotations__["event"] = gr.SelectData
    private, at_picture = {"api_visibility": "private"}, model_at(clip["picture"])
    file, anew = clip["path"], [*outputs, clip["path"], *span]
    file.upload(with_errors_shown(open_clip), [file, *looked_at], anew, **at_picture)
    for trigger in (file.clear, file.delete):
        trigger(with_errors_shown(take_away), [file, *looked_at], anew, **at_picture)
    clip["gallery"].select(with_errors_shown(open_example), looked_at, anew, **at_picture)
    given = [source, *span, *looked_at]
    clip["read"].click(with_errors_shown(read_again), given, outputs, **at_picture)
    pictured = [shown, clip["view"], clip["number"]]
    for control in (clip["view"], clip["number"]):
        control.change(handlers.draw, pictured, clip["picture"], **private)


def _opened(
    opened: Any,
    source: Any,
    view: str,
    number: float,
    facts: list[str],
    mm_per_px: float | None,
    before: Any,
) -> tuple:
    if before is not None and _size(before) != _size(opened):
        mm_per_px = 0  # what was said of other pixels
    drawn = handlers.draw(opened, view, number)
    return opened, source, drawn, literal(opened.notes), frame_preview(facts, None)[1], mm_per_px


def _closed(
    source: Any, view: str, number: float, facts: list[str], mm_per_px: float | None, before: Any
) -> tuple:
    """Return what is shown when no clip is; the size of a pixel goes with the clip it was of."""
    known = mm_per_px if before is None else 0
    return None, source, None, "", frame_preview(facts, None)[1], known


def _size(shown: Any) -> tuple[int, int]:
    return shown.encoded.clip.frames.shape[1:3]


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
