"""The Simulate tab: a touch by sliders, its true field over the learned one, answer and error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm import TRUE_DISPLACEMENT, GeoTLMError, Seen

from . import stage
from .clips import LoadedClip, perceive
from .talking import along
from .toolkit import COMPLAINT, Filled, complaint, filling, gradio, literal, model_at

if TYPE_CHECKING:
    from geotlm_lm import Answerer, Touch

DIRECTION_QUESTION, AMOUNT_QUESTION = "Which way is it moving?", "How far did it go?"
"""Asked of what was just simulated."""

OBJECTS = (
    *("key", "bottle_cap", "hex_nut", "screw_head", "coin", "bead", "pen_clip", "textured_ball"),
    *("can_rim", "corner", "cable", "table_edge"),
)
"""Shapes on offer: everyday things that no weight was trained on."""

INVITES = (
    "Set a touch by the sliders and press Simulate and ask: what truly happens and what the model "
    "reads are drawn over each other here."
)

HEADERS = ["", "true", "read", "error"]

ROWS = {
    "rotation_deg": "turn, degrees clockwise",
    "slide_x_px": "slide to the right, px",
    "slide_y_px": "slide down, px",
    "press_mm": "press inward, mm",
}

NUMBERS = (
    *("twist_deg", "slide_x_mm", "slide_y_mm", "press_mm", "depth_mm", "thickness_mm"),
    "friction",
)
"""Fields of a `Touch`, in the order of the sliders."""


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    parts: dict[str, Any] = {}
    with gr.Row():
        with gr.Column(scale=2, min_width=300):
            sliders = _sliders(gr)
            go = gr.Button("Simulate and ask", variant="primary")
            parts[COMPLAINT] = complaint()
        with gr.Column(scale=3, min_width=320):
            parts["stage"] = stage.build(invites=INVITES)
            parts["sentence"] = gr.Markdown()
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
            "stage": stage.stage_of(made.shown, name.replace("_", " "), truth=made.truth),
            "sentence": f"### {literal(sentence_of(made.facts))}\n{truth_of(made.facts['true'])}",
            "facts": [
                [name, *(made.facts[kind][key] for kind in HEADERS[1:])]
                for key, name in ROWS.items()
            ],
        }

    shown = [parts[name] for name in ("stage", "sentence", "facts", COMPLAINT)]
    go.click(filling(parts, run), sliders, shown, **model_at(parts["sentence"]))


def sentence_of(facts: Mapping[str, Any]) -> str:
    """Return the answer and whether it is correct; "right" would be taken for a direction."""
    true = " and ".join(facts["true_ways"] or [facts["true_motion"]])
    verdict = "correct" if facts["is_right"] else "wrong"
    return f"{facts['answer']}  ({verdict}: it was {true})"


def truth_of(true: Mapping[str, float]) -> str:
    """Return the true motion of the contact with all its components."""
    numbers = true["rotation_deg"], true["slide_x_px"], true["slide_y_px"]
    depth = true["press_mm"]
    pressed = f"{abs(depth):.2f} mm {'inward' if depth > 0 else 'outward'}" if depth else ""
    parts = ", ".join(filter(None, [along(*numbers), pressed])) or "at rest"
    return f"True, about the middle of the contact: {parts}."


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


@dataclass(frozen=True, eq=False)
class Simulated:
    """A simulated touch: as the model sees it, with its true displacement, and both compared.

    `truth` is from the first frame to the last, the learned field from the first two to the last
    two; `facts` are plain values: truth, reading, and the error between them.
    """

    shown: LoadedClip
    truth: Seen
    facts: dict[str, Any]


def touch_of(name: Any, numbers: Mapping[str, Any], seed: Any) -> Touch:
    """Return the touch of a shape with these fields, or say in one sentence what is wrong."""
    from geotlm_lm import Touch

    given = {field: _number(field, value) for field, value in numbers.items()}
    whole = _number("seed", seed)
    if not whole.is_integer():
        raise GeoTLMError(f"seed is {whole:g}, expected a whole number from 0.")
    return Touch("" if name is None else str(name), **given, seed=int(whole))


def _number(field: str, value: Any) -> float:
    if value is None or value == "":
        raise GeoTLMError(f"{field} was left empty; give a number.")
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise GeoTLMError(f"{field} is {str(value)[:40]!r}, expected a number.") from error


def simulate(answerer: Answerer, touch: Touch) -> Simulated:
    """Simulate a touch, ask about it, and compare the answer with the truth."""
    from geotlm_lm import simulate_touch

    made = simulate_touch(touch)
    shown = perceive(answerer, made.clip, depth_mm=made.depth_mm)
    answer = answerer.ask(shown.encoded, DIRECTION_QUESTION)
    how_far = answerer.ask(shown.encoded, AMOUNT_QUESTION)
    true, read = (_numbers(twist) for twist in (made.twist, shown.encoded.belief.mean))
    components = made.components
    # Those that it goes, or goes perhaps.
    ways = (part.way for part in components.values() if part.moves is not False)
    facts = {
        "answer": answer.text,
        "how_far": how_far.text,
        "direction": None if answer.direction is None else answer.direction.value,
        "confidence": round(answer.confidence, 4),
        "true_motion": made.label.motion.value,
        "true_ways": [part.way.value for part in components.values() if part.moves],
        "moves": {name.value: part.moves for name, part in components.items()},
        "is_visible": {name.value: part.is_visible for name, part in components.items()},
        "is_right": answer.direction in {made.label.motion, *ways},
        "true": _rounded(true),
        "read": _rounded(read),
        "error": _rounded({name: read[name] - true[name] for name in read}),
        "timing_ms": _rounded(made.timing_ms),
    }
    return Simulated(shown, _truth(made, shown), facts)


def _numbers(twist: Any) -> dict[str, float]:
    return {
        "rotation_deg": twist.turn_deg,
        "slide_x_px": twist.right_px,
        "slide_y_px": twist.down_px,
        "press_mm": twist.inward_mm,
    }


def _truth(made: Any, shown: LoadedClip) -> Seen:
    seen, contact = shown.seen, made.contact.mean(axis=0)
    return Seen(
        seen.frames,
        seen.idle,
        made.displacement_px[-1],
        contact,
        type(seen.view)(),
        has_contact=bool(contact.any()),
        scale=TRUE_DISPLACEMENT,
    )


def _rounded(values: dict[str, float]) -> dict[str, float]:
    return {name: round(float(np.float64(value)), 2) for name, value in values.items()}
