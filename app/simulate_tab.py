"""The Simulate tab: a touch by sliders, its true field over the learned one, answer and error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import gradio as gr
import numpy as np

import geotlm_lm as lm

from . import stage
from .clips import LoadedClip, perceive
from .toolkit import COMPLAINT, MODEL, QUIET, Filled, complaint, on

OBJECTS = (
    *("key", "bottle_cap", "hex_nut", "screw_head", "coin", "bead", "pen_clip", "textured_ball"),
    *("can_rim", "corner", "cable", "table_edge"),
)
"""Shapes on offer: everyday things that no weight was trained on."""

INVITES = "Set a touch by the sliders: what truly happens and what the model reads are drawn here."

COMPONENTS = {
    "turn": ("rotation_deg", "°", ("clockwise", "counterclockwise")),
    "across": ("slide_x_px", " px", ("right", "left")),
    "down": ("slide_y_px", " px", ("down", "up")),
    "press": ("press_mm", " mm", ("in", "out")),
}
"""Names of the rows that are drawn: number, unit, and its ways, the positive one first."""

PRESETS = ("draft", "good")
"""Of the simulator, the quick one first."""

SLIDERS = {
    "twist_deg": (-60, 60, 15, 1, "Turn, degrees (positive: clockwise)"),
    "slide_x_mm": (-5, 5, 0.4, 0.1, "Slide to the right, mm"),
    "slide_y_mm": (-5, 5, 0, 0.1, "Slide down, mm"),
    "press_mm": (-1.5, 1.5, 0, 0.05, "Press inward, mm (negative: lift)"),
    "depth_mm": (-0.2, 1.5, 0.6, 0.05, "Depth half-way, mm"),
    "thickness_mm": (1, 6, 4, 0.1, "Gel thickness, mm"),
    "friction": (0, 3, 1, 0.1, "Friction coefficient"),
}
"""Fields of a `Touch`: least, most, first value, step and label of each."""


def build(answerer: lm.Answerer, tab: Any) -> None:
    """Lay the tab (a `gradio.Tab`) out and connect it; call it inside.

    It is simulated when the tab is shown and whenever a slider moves: a draft, then a better one.
    """
    parts: dict[str, Any] = {}
    with gr.Row(elem_classes=["simulate"]):
        with gr.Column(scale=2, min_width=300):
            parts["object"] = gr.Dropdown(list(OBJECTS), value="key", label="Object")
            for field, (low, high, value, step, label) in SLIDERS.items():
                parts[field] = gr.Slider(low, high, value=value, step=step, label=label)
            parts["seed"] = gr.Number(value=0, precision=0, minimum=0, label="Seed")
            sliders = list(parts)
            parts[COMPLAINT] = complaint()
        with gr.Column(scale=3, min_width=320):
            parts["stage"] = stage.build(INVITES)

    moved = [tab.select, *(parts[name].input for name in sliders)]
    newest = {**QUIET, **MODEL, "trigger_mode": "always_last"}
    on(parts, moved, partial(simulated, answerer), sliders, ["stage"], **newest)


def simulated(answerer: lm.Answerer, name: str, *given: float | None) -> Iterator[Filled]:
    """Yield the stage of a touch by its sliders; one that cannot be leaves the former there."""
    *numbers, seed = given
    touch = touch_of(name, dict(zip(SLIDERS, numbers, strict=True)), seed)
    for preset in PRESETS:
        made = simulate(answerer, touch, preset)
        values = stage.stage_of(made.shown, name.replace("_", " "), truth=made.truth)
        if values["step"]["rows"]:
            values["step"]["rows"] = _rows(made)
        yield {"stage": values | {"notes": [f"{made.facts['answer']}  ({made.verdict})"]}}


def _rows(made: Simulated) -> list[dict[str, Any]]:
    """Return what is read of each component, with the span of nine tenths, and the truth."""
    deviations = np.sqrt(np.diag(made.shown.encoded.belief.covariance))
    rows = []
    for (name, (key, unit, ways)), deviation in zip(COMPONENTS.items(), deviations, strict=True):
        read, true = made.facts["read"][key], made.facts["true"][key]
        reach = lm.SPAN_DEVIATIONS * float(deviation)
        texts = (
            f"{lm.figure_of(abs(far))}{unit} {ways[far < 0]}" if far else "none"
            for far in (read, true)
        )
        text = "read {}, true {}".format(*texts)
        span = {"mean": read, "low": read - reach, "high": read + reach, "true": true}
        rows.append({"name": name, "moves": bool(true), "text": text} | span)
    return rows


@dataclass(frozen=True, eq=False)
class Simulated:
    """A simulated touch: as the model sees it, with its true displacement, and both compared.

    `truth` is from the first frame to the last, the learned field from the first two to the last
    two; `facts` are plain values: truth, reading, and the error between them. The verdict tells
    what of the answer is right; "right" would be taken for a direction.
    """

    shown: LoadedClip
    truth: lm.Seen
    facts: dict[str, Any]
    verdict: str


def touch_of(name: Any, numbers: Mapping[str, Any], seed: Any) -> lm.Touch:
    """Return the touch of a shape with these fields, or say in one sentence what is wrong."""
    given = {field: _number(field, value) for field, value in numbers.items()}
    whole = _number("seed", seed)
    if not whole.is_integer():
        raise lm.GeoTLMError(f"seed is {whole:g}, expected a whole number from 0.")
    return lm.Touch("" if name is None else str(name), **given, seed=int(whole))


def _number(field: str, value: Any) -> float:
    if value is None or value == "":
        raise lm.GeoTLMError(f"{field} was left empty; give a number.")
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise lm.GeoTLMError(f"{field} is {str(value)[:40]!r}, expected a number.") from error


def simulate(answerer: lm.Answerer, touch: lm.Touch, preset: str = "fast") -> Simulated:
    """Simulate a touch, ask about it, and compare the answer with the truth."""
    made = lm.simulate_touch(touch, preset=preset)
    shown = perceive(answerer, made.clip, depth_mm=made.depth_mm)
    return Simulated(shown, _truth(made, shown), *lm.ask_simulated(answerer, made, shown.encoded))


def _truth(made: Any, shown: LoadedClip) -> lm.Seen:
    seen, contact = shown.seen, made.contact.mean(axis=0)
    return lm.Seen(
        seen.frames,
        seen.idle,
        made.displacement_px[-1],
        contact,
        type(seen.view)(),
        has_contact=bool(contact.any()),
        scale=lm.TRUE_DISPLACEMENT,
    )
