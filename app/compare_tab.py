"""The Compare tab: two clips, both answers, and how their directions are related."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from . import handlers
from .clip_loading import SUFFIXES, load_clip
from .clip_side import BUTTONS
from .error_display import gradio, literal, model_at, with_errors_shown

if TYPE_CHECKING:
    from geotlm_lm import Answerer


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    sides = []
    with gr.Row():
        for label in ("First recording", "Second recording"):
            with gr.Column():
                path = gr.File(label=label, file_types=SUFFIXES, type="filepath", height=120)
                gr.Examples([[clip] for clip in handlers.EXAMPLE_CLIPS], [path], label="Examples")
                picture = gr.Image(
                    label="Shear change and contact", interactive=False, buttons=BUTTONS
                )
                sides.append((path, picture, gr.Markdown()))
    go = gr.Button("Compare", variant="primary")
    verdict, details = gr.Markdown(), gr.JSON(label="Both answers", open=False)

    # Not `compare`: an event takes its function's name, and that one is the programs'.
    def compare_both(first: str | None, second: str | None) -> Iterator[tuple[Any, ...]]:
        try:
            shown = [load_clip(answerer, path) if path else None for path in (first, second)]
            result = handlers.compare(answerer, *shown)
        except Exception:
            yield None, None, "", "", "", None  # what was said of the recordings before
            raise
        pictures = [handlers.draw(one, "arrows", 4) for one in shown]
        texts = [literal(result[one]["text"]) for one in ("first", "second")]
        yield (*pictures, *texts, f"### {literal(result['text'])}", result)

    (first, first_picture, first_text), (second, second_picture, second_text) = sides
    outputs = [first_picture, second_picture, first_text, second_text, verdict, details]
    go.click(with_errors_shown(compare_both), [first, second], outputs, **model_at(verdict))
    for path, picture, text in sides:
        emptied = [picture, text, verdict, details]
        # Not queued: it would empty what a click right after the upload has told.
        path.change(
            lambda: (None, "", "", None), None, emptied, api_visibility="private", queue=False
        )
