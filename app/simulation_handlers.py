"""Handlers of the Simulate tab: a touch, its true field, the answer, and its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm import TRUE_DISPLACEMENT, GeoTLMError, Seen

from .clip_loading import LoadedClip, perceive
from .handlers import AMOUNT_QUESTION, DIRECTION_QUESTION

if TYPE_CHECKING:
    from geotlm_lm import Answerer, Motion, Touch

OBJECTS = (
    "key",
    "bottle_cap",
    "hex_nut",
    "screw_head",
    "coin",
    "bead",
    "pen_clip",
    "textured_ball",
    "can_rim",
    "corner",
    "cable",
    "table_edge",
)
"""Shapes on offer: everyday things that no weight was trained on."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """A simulated touch as the page shows it.

    Args:
        shown: The clip, as the model sees it.
        truth: The same with the true displacement, to be drawn as the learned one is: from the
            first frame to the last; the learned one is from the first two to the last two.
        facts: Plain values: truth, reading, and the error between them.
    """

    shown: LoadedClip
    truth: Seen
    facts: dict[str, Any]


def touch_of(name: Any, numbers: Mapping[str, Any], seed: Any) -> Touch:
    """Return the touch that was asked for.

    Args:
        name: Of the shape.
        numbers: Lengths, angles and friction, by the names of the touch's fields.
        seed: A whole number.

    Raises:
        GeoTLMError: If a number is missing or none, in one sentence.
    """
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
    """Simulate a touch, ask about it, and tell the answer's error.

    Raises:
        GeoTLMError: If the touch cannot be simulated.
    """
    from geotlm_lm import simulate_touch

    made = simulate_touch(touch)
    shown = perceive(answerer, made.clip, depth_mm=made.depth_mm)
    answer = answerer.ask(shown.encoded, DIRECTION_QUESTION)
    how_far = answerer.ask(shown.encoded, AMOUNT_QUESTION)
    true, read = (_numbers(twist) for twist in (made.twist, shown.encoded.belief.mean))
    components = made.components
    facts = {
        "answer": answer.text,
        "how_far": how_far.text,
        "direction": None if answer.direction is None else answer.direction.value,
        "confidence": round(answer.confidence, 4),
        "true_motion": made.label.motion.value,
        "true_ways": [one.way.value for one in components.values() if one.counts],
        "counts": {name.value: one.counts for name, one in components.items()},
        "is_visible": {name.value: one.is_visible for name, one in components.items()},
        "is_right": _is_right(answer.direction, made),
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


def _is_right(direction: Motion | None, made: Any) -> bool:
    """Tell whether a direction is one of those the touch goes, or goes perhaps."""
    ways = {one.way for one in made.components.values() if one.counts is not False}
    return direction == made.label.motion or direction in ways


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
