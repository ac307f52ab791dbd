"""Answers about a simulated touch beside its truth, as plain values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.query.judge import judge_motion

if TYPE_CHECKING:
    from geotlm_lm.answering.answerer import Answerer
    from geotlm_lm.answering.encoded import Encoded
    from geotlm_lm.simulation.simulate import SimulatedClip

DIRECTION_QUESTION, AMOUNT_QUESTION = "Which way is it moving?", "How far did it go?"


def ask_simulated(
    answerer: Answerer, made: SimulatedClip, encoded: Encoded
) -> tuple[dict[str, Any], str]:
    """Ask about a simulated clip; return answers, truth and errors, and the verdict in words.

    Lengths are in pixels of the 224-pixel image.
    """
    answer = answerer.ask(encoded, DIRECTION_QUESTION)
    twist, components = made.twist, made.components
    moves = {name: part.moves for name, part in components.items()}
    is_visible = {name: part.is_visible for name, part in components.items()}
    touches = made.label.motion is not Motion.NONE
    judged = judge_motion(answer.values[0], twist, moves, is_visible, touches=touches)
    ways = {name: [part.way] for name, part in components.items() if part.moves}
    if Component.SLIDE in ways:
        ways[Component.SLIDE] += [way for way in twist.lesser_way()[:1] if way is not None]
    true, read = _numbers(twist), _numbers(encoded.belief.mean)
    facts = {
        "answer": answer.text,
        "how_far": answerer.ask(encoded, AMOUNT_QUESTION).text,
        "direction": None if answer.direction is None else answer.direction.value,
        "confidence": round(answer.confidence, 4),
        "true_motion": made.label.motion.value,
        "true_ways": [way.value for part in ways.values() for way in part],
        "moves": {name.value: value for name, value in moves.items()},
        "is_visible": {name.value: value for name, value in is_visible.items()},
        "is_right": judged.is_right,
        "true": _rounded(true),
        "read": _rounded(read),
        "error": _rounded({name: read[name] - true[name] for name in read}),
        "timing_ms": _rounded(made.timing_ms),
    }
    return facts, judged.text


def _numbers(twist: Twist) -> dict[str, float]:
    return {
        "rotation_deg": twist.turn_deg,
        "slide_x_px": twist.right_px,
        "slide_y_px": twist.down_px,
        "press_mm": twist.inward_mm,
    }


def _rounded(values: dict[str, float]) -> dict[str, float]:
    return {name: round(float(value), 2) for name, value in values.items()}
