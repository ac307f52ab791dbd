"""The Simulate tab: a touch by sliders, its true field, the model's answer and its error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from . import handlers
from .clip_side import BUTTONS
from .error_display import gradio, literal, model_at, with_errors_shown
from .play_button import add_play_button
from .simulation_handlers import OBJECTS, simulate, touch_of

if TYPE_CHECKING:
    from geotlm_lm import Answerer

VIEWS = ["raw", "difference", "contact", "arrows", "depth"]

NUMBERS = (
    "twist_deg",
    "slide_x_mm",
    "slide_y_mm",
    "press_mm",
    "depth_mm",
    "thickness_mm",
    "friction",
)
"""Fields of a `Touch`, in the order of the sliders."""


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    shown = gr.State()
    with gr.Row():
        with gr.Column():
            sliders = _sliders(gr)
            go = gr.Button("Simulate and ask", variant="primary")
            sentence = gr.Markdown()
            facts = gr.JSON(label="Truth, reading and error")
        with gr.Column():
            with gr.Row():
                view = gr.Radio(VIEWS, value="raw", label="View")
                with gr.Column():
                    number = gr.Slider(1, 4, value=4, step=1, label="Frame")
                    add_play_button(gr, number)
            picture = gr.Image(label="The clip", interactive=False, buttons=BUTTONS)
            with gr.Row():
                truth = gr.Image(label="True displacement", interactive=False, buttons=BUTTONS)
                read = gr.Image(label="Learned shear change", interactive=False, buttons=BUTTONS)

    def run(seen: str, place: float, name: str, *given: float | None) -> Iterator[tuple]:
        *numbers, seed = given
        try:
            touch = touch_of(name, dict(zip(NUMBERS, numbers, strict=True)), seed)
            made = simulate(answerer, touch)
        except Exception:
            yield None, None, None, None, "", None  # what was said of the touch before
            raise
        yield (
            made.shown,
            handlers.draw(made.shown, seen, place),
            made.truth_picture,
            made.read_picture,
            f"### {literal(sentence_of(made.facts))}\n{truth_of(made.facts['true'])}",
            made.facts,
        )

    outputs = [shown, picture, truth, read, sentence, facts]
    go.click(with_errors_shown(run), [view, number, *sliders], outputs, **model_at(picture))
    for control in (view, number):
        control.change(handlers.draw, [shown, view, number], picture, api_visibility="private")


def sentence_of(facts: Mapping[str, Any]) -> str:
    """Return the answer and whether it is correct; "right" would be taken for a direction."""
    true = " and ".join(facts["true_ways"] or [facts["true_motion"]])
    verdict = "correct" if facts["is_right"] else "wrong"
    return f"{facts['answer']}  ({verdict}: it was {true})"


def truth_of(true: Mapping[str, float]) -> str:
    """Return the true motion of the contact with all its components."""
    return (
        f"True, about the middle of the contact: {true['rotation_deg']:+.1f} degrees clockwise, "
        f"{true['slide_x_px']:+.1f} px right, {true['slide_y_px']:+.1f} px down, "
        f"{true['press_mm']:+.2f} mm inward."
    )


def _sliders(gr: Any) -> list[Any]:
    """Return the object, what is done to it in the order of `NUMBERS`, and the seed."""
    return [
        gr.Dropdown(list(OBJECTS), value="key", label="Object"),
        gr.Slider(-60, 60, value=15, step=1, label="Turn, degrees (positive: clockwise)"),
        gr.Slider(-5, 5, value=0.4, step=0.1, label="Slide to the right, mm"),
        gr.Slider(-5, 5, value=0, step=0.1, label="Slide down, mm"),
        gr.Slider(-1.5, 1.5, value=0, step=0.05, label="Press inward, mm (negative: lift)"),
        gr.Slider(-0.2, 1.5, value=0.6, step=0.05, label="Depth half-way, mm"),
        gr.Slider(1, 6, value=4, step=0.1, label="Gel thickness, mm"),
        gr.Slider(0, 3, value=1, step=0.1, label="Friction coefficient"),
        gr.Number(value=0, precision=0, minimum=0, label="Seed"),
    ]
