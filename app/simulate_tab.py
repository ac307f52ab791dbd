"""The Simulate tab: a touch by sliders, its true field over the learned one, answer and error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from . import stage
from .error_display import gradio, literal, model_at
from .filling import COMPLAINT, Filled, complaint, filling
from .simulation_handlers import OBJECTS, simulate, touch_of

if TYPE_CHECKING:
    from geotlm_lm import Answerer

HEADERS = ["", "true", "read", "error"]

ROWS = {
    "rotation_deg": "turn, degrees clockwise",
    "slide_x_px": "slide to the right, px",
    "slide_y_px": "slide down, px",
    "press_mm": "press inward, mm",
}

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
    parts: dict[str, Any] = {}
    with gr.Row():
        with gr.Column(scale=4, min_width=300):
            sliders = _sliders(gr)
            go = gr.Button("Simulate and ask", variant="primary")
            parts[COMPLAINT] = complaint()
        with gr.Column(scale=6, min_width=320):
            parts["stage"] = stage.build()
            parts["sentence"] = gr.Markdown(
                "Set a touch by the sliders: what truly happened and what the model reads are "
                "drawn over each other here."
            )
            parts["facts"] = gr.Dataframe(
                headers=HEADERS, label="Truth, reading and error", interactive=False
            )

    def run(name: str, *given: float | None) -> Iterator[Filled]:
        *numbers, seed = given
        try:
            touch = touch_of(name, dict(zip(NUMBERS, numbers, strict=True)), seed)
            made = simulate(answerer, touch)
        except Exception:
            yield {"stage": {}, "sentence": "", "facts": None}  # of the touch before
            raise
        yield {
            "stage": stage.stage_of(made.shown, name.replace("_", " "), fields=[_truth(made)]),
            "sentence": f"### {literal(sentence_of(made.facts))}\n{truth_of(made.facts['true'])}",
            "facts": rows_of(made.facts),
        }

    shown = [parts[name] for name in ("stage", "sentence", "facts", COMPLAINT)]
    go.click(filling(parts, run), sliders, shown, **model_at(parts["sentence"]))


def _truth(made: Any) -> dict[str, Any]:
    return stage.field_of(made.truth, "truth", "true motion", "#35e0ff")


def rows_of(facts: Mapping[str, Any]) -> list[list[Any]]:
    """Return a row for each number: its name, the truth, what was read, and the error."""
    return [
        [name, *(facts[one][key] for one in ("true", "read", "error"))]
        for key, name in ROWS.items()
    ]


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
