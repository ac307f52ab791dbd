"""The page: what stands where, and which function answers; all work is done in `handlers`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geotlm_lm import Answerer, GeoTLMError
from geotlm_lm.core.errors import MissingDependency

from .handlers import EXAMPLE_QUESTIONS, ask, show_clip

SUFFIXES = [".npy", ".npz", ".mp4", ".avi", ".mov", ".mkv"]

EXAMPLE_CLIPS = sorted(str(path) for path in (Path(__file__).parent / "examples").glob("*.npz"))

FRAME_OF_REFERENCE = (
    "Directions are told **as seen in the camera image** (looking out of the sensor at the "
    "object), for the object relative to the sensor."
)


def build(answerer: Answerer) -> Any:
    """Return the page (a `gradio.Blocks`), not yet served.

    Raises:
        MissingDependency: If gradio is not installed.
    """
    try:
        import gradio as gr
    except ImportError as error:
        raise MissingDependency(
            "The app needs gradio, which is not installed; run `pip install 'geotlm-lm[app]'`."
        ) from error

    def on_clip(path: str | None, first: float | None, last: float | None) -> tuple:
        try:
            shown = show_clip(answerer, path, first, last)
        except GeoTLMError as error:
            raise gr.Error(str(error), print_exception=False) from error
        return shown, shown.frames, shown.arrows, shown.notes, None, None, None

    def on_question(shown: Any, question: str) -> tuple:
        try:
            reply = ask(answerer, shown, question)
        except GeoTLMError as error:
            raise gr.Error(str(error), print_exception=False) from error
        return reply.sentence, reply.probabilities, reply.details

    # Without analytics nothing leaves the machine, and the page starts offline without a wait.
    with gr.Blocks(title="geotlm-lm", analytics_enabled=False) as page:
        shown = gr.State()
        gr.Markdown(f"# Ask a touch sensor how the object moves\n\n{FRAME_OF_REFERENCE}")
        with gr.Row():
            with gr.Column():
                path = gr.File(label="Recording", file_types=SUFFIXES, type="filepath")
                gr.Examples([[clip] for clip in EXAMPLE_CLIPS], inputs=[path], label="Examples")
                with gr.Row():
                    first = gr.Number(label="First frame (empty: chosen)", precision=0, value=None)
                    last = gr.Number(label="Last frame", precision=0, value=None)
                read = gr.Button("Read the recording")
                frames = gr.Gallery(label="Frames that are used", columns=4, height="auto")
                notes = gr.Markdown()
            with gr.Column():
                question = gr.Textbox(label="Question", value=EXAMPLE_QUESTIONS[0])
                gr.Examples([[text] for text in EXAMPLE_QUESTIONS], inputs=[question])
                go = gr.Button("Ask", variant="primary")
                sentence = gr.Textbox(label="Answer", interactive=False)
                probabilities = gr.Label(label="Calibrated probabilities")
                arrows = gr.Image(label="Learned shear change (pattern only, no unit)")
                details = gr.JSON(label="Everything the answer rests on", open=False)
        outputs = [shown, frames, arrows, notes, sentence, probabilities, details]
        for event in (path.upload, read.click):
            event(on_clip, [path, first, last], outputs, concurrency_limit=1)
        for event in (go.click, question.submit):
            event(
                on_question,
                [shown, question],
                [sentence, probabilities, details],
                concurrency_limit=1,
            )
    return page
