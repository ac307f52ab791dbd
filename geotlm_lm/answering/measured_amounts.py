"""Measure how far the imprint of a clip moved, with the odometer.

A turn is told in degrees; the unit of a slide follows from what is known of the recording.
"""

from __future__ import annotations

import math
import re
import time
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.answering.abstention import neutral_answer, tentative_text, too_little_contact
from geotlm_lm.answering.amounts import NAMES, Amount, best_amount
from geotlm_lm.answering.answer import KIND_OF_UNIT, Answer, Encoded, deciding_word
from geotlm_lm.answering.model_query import ModelReply, is_uncertain
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.requested_units import asks_per_frame, requested_unit
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import camera_size, filled_size, pixel_aspect
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.core.tolerance import TOLERANCES
from geotlm_lm.language.parse_answer import Unit
from geotlm_lm.odometry.movement import movement, way_of_slide
from geotlm_lm.odometry.odometer import amounts

PIXELS_NOTE = (
    "Pixels of the recording's {}x{} frames: nothing tells how large one is on the gel; say for "
    "example '0.06 mm per pixel'."
)
NO_LENGTH = " In millimetres only if you tell me the size of a pixel."

_LENGTH = re.compile(
    r"\b(?:mm|cm|um|millimet(?:er|re)s?|centimet(?:er|re)s?|micromet(?:er|re)s?|microns?|inch(?:es)?)\b",
    re.IGNORECASE,
)
"""Asks for a length on the gel."""

NO_TIME = "I cannot tell the speed: it takes 3 frames and a frame rate; give it by fps."


def answer_measured(
    bundle: Bundle, encoded: Encoded, question: str, heard: ModelReply, frame: FrameSpec
) -> Answer:
    """Answer how far it went, or how fast, with what the odometer measures.

    Withheld where next to nothing touches, where a speed has no time, and where it may as well not
    turn or slide at all; the number itself is told however unsure it is, with its span.
    """
    kind = heard.slots.kind
    if encoded.contact_share < bundle.calibration.contact_threshold:
        what = "say how fast" if kind == "rate" else "say how far"
        text = too_little_contact(what, encoded.contact_share)
        return neutral_answer(encoded, text, kind, frame, heard.timing_ms)
    if kind == "rate" and not encoded.seconds:
        return neutral_answer(encoded, NO_TIME, kind, frame, heard.timing_ms)
    started = time.perf_counter()
    whole = amount = measured_amount(bundle, encoded, heard, frame)
    timing = heard.timing_ms | {"measure": 1e3 * (time.perf_counter() - started)}
    if kind == "rate":
        amount = whole.per_second(encoded.seconds)
    text, notes = amount.sentence(_where(encoded)) + _in_other_units(encoded, question, amount), ()
    if whole.unit == "px":
        rows, columns = encoded.clip.frames.shape[1:3]
        notes = (PIXELS_NOTE.format(columns, rows),)
        text += NO_LENGTH if _LENGTH.search(question) else ""
    word = deciding_word(heard.slots)
    if is_uncertain(kind, word, heard.options):
        text = tentative_text(text, heard.options[word])
        return replace(neutral_answer(encoded, text, kind, frame, timing), options=heard.options)
    answer = neutral_answer(encoded, text, kind, frame, timing)
    return replace(
        answer,
        notes=(*answer.notes, *notes),
        confidence=amount.probability,
        abstained=False,
        options=heard.options,
        decided=whole.word,
        amount=amount,
    )


def measured_amount(
    bundle: Bundle, encoded: Encoded, heard: ModelReply, frame: FrameSpec
) -> Amount | None:
    """Return the amount from the first to the last frame; None without a motion.

    The language model says whether it turned or slid, the odometer how far. The amount's
    probability is that of both. An amount of a slide is right within `TOLERANCES["px"]`, whatever
    the unit it is told in.

    Args:
        bundle: The model.
        encoded: The clip.
        heard: What the model said to a question about an amount.
        frame: Tells the size of a pixel, if anybody does; slides are told in pixels otherwise.
    """
    if heard.slots is None or heard.slots.unit is None:
        return None
    read = heard.slots.unit
    weighed = amount_distribution(bundle, encoded, read, frame)
    amount = best_amount(*astuple(weighed))
    return replace(amount, probability=amount.probability * heard.options[KIND_OF_UNIT[read]])


def _where(encoded: Encoded) -> str:
    """Return between which frames an amount is, if they are a part of the recording."""
    numbers = encoded.clip.frame_numbers
    return f"between frames {min(numbers)} and {max(numbers)}" if encoded.is_part else ""


def _in_other_units(encoded: Encoded, question: str, amount: Amount) -> str:
    """Return the amount in the unit that the question names, if it is told in another one."""
    numbers = encoded.clip.frame_numbers
    steps = max(numbers) - min(numbers)
    if asks_per_frame(question) and steps:
        unit, *rate = amount.unit.split("/")
        together = encoded.seconds if rate else 1.0
        return f" {amount.also(together / steps, f'{NAMES[unit][1]} per frame on average')}"
    asked = requested_unit(question, amount.unit)
    return "" if asked is None else f" {amount.also(asked[1], asked[0])}"


@dataclass(frozen=True, eq=False)
class AmountDistribution:
    """The probability of each amount, given that the clip turns or slides.

    Args:
        amounts: Rising, in `unit`.
        shares: Probability of each; they sum to 1.
        unit: In which they are told: "deg", "px" of the recording's frames, or "mm".
        tolerance: Least error of an answer that still counts as right, in `unit`.
    """

    amounts: tuple[float, ...]
    shares: NDArray[np.float64]
    unit: str
    tolerance: float


def amount_distribution(
    bundle: Bundle, encoded: Encoded, read: Unit, frame: FrameSpec
) -> AmountDistribution:
    """Return the probability of each amount.

    Args:
        bundle: The model.
        encoded: The clip.
        read: "deg" of what turned, "px" of what slid.
        frame: Tells the size of a pixel, if anybody does.
    """
    told, scale = (read, 1.0) if read == "deg" else _slide_scale(encoded, frame)
    shares = _distribution(bundle, encoded, read) ** (1 / encoded.doubt)
    weighed = tuple((amounts(read) * scale).tolist())
    return AmountDistribution(weighed, shares / shares.sum(), told, TOLERANCES[read] * scale)


def amount_along(
    bundle: Bundle, encoded: Encoded, motion: Motion
) -> tuple[float, float, float] | None:
    """Return the amount of the turn or slide `motion`; None for other motions.

    By the odometer's geometric mean.

    Returns:
        Degrees clockwise, and pixels of the clip's own frames to the right and down, from the first
        frame to the last.
    """
    if motion not in DIRECTED:
        return None
    unit = "deg" if motion in ROTATIONS else "px"
    shares = _distribution(bundle, encoded, unit)
    far = math.exp(float(shares @ amounts(unit).log().numpy()))
    if unit == "deg":
        return (far if motion is Motion.CLOCKWISE else -far), 0.0, 0.0
    (right, down), (across, along) = way_of_slide(encoded.stem_inputs), _own_pixels(encoded)
    return 0.0, far * right * across, far * down * along


def _distribution(bundle: Bundle, encoded: Encoded, unit: str) -> NDArray[np.float64]:
    """Return the probability of each of `amounts(unit)`."""
    aspect = pixel_aspect(*encoded.clip.frames.shape[1:3])
    seen, geometry = encoded.stem_inputs, encoded.perception.geometry
    moved = movement(seen, geometry, encoded.equalised_motions, aspect)
    shares = bundle.odometer.read(moved, unit)[0].double().numpy()
    return shares / shares.sum()


def _slide_scale(encoded: Encoded, frame: FrameSpec) -> tuple[str, float]:
    """Return the unit slides are told in, and how much of it a pixel of the 224-pixel image is.

    The frames' pixels may be of another size across than down: the way of the slide decides.
    """
    (right, down), (wide, high) = way_of_slide(encoded.stem_inputs), _own_pixels(encoded)
    across, along = right * wide, down * high
    if frame.mm_per_px is None:
        return "px", math.hypot(across, along)
    # A camera's own pixels are square; those of our square image are wider than high.
    return "mm", frame.mm_per_px * math.hypot(across, along * _height_of_a_pixel(encoded))


def slide_direction(encoded: Encoded, unit: str) -> tuple[float, float]:
    """Return the direction of the slide, right and down, as a unit vector in `unit`.

    Args:
        encoded: The clip.
        unit: "px" of the recording's frames, or "mm".
    """
    (right, down), (wide, high) = way_of_slide(encoded.stem_inputs), _own_pixels(encoded)
    across, along = right * wide, down * high
    along *= _height_of_a_pixel(encoded) if unit == "mm" else 1.0
    length = math.hypot(across, along)
    return across / length, along / length


def _height_of_a_pixel(encoded: Encoded) -> float:
    """Return how much higher than wide a pixel of the recording's frames is."""
    rows, columns = encoded.clip.frames.shape[1:3]
    camera_rows, camera_columns = camera_size(rows, columns)
    return camera_rows / rows * columns / camera_columns


def _own_pixels(encoded: Encoded) -> tuple[float, float]:
    """Return how many of the recording's pixels one of the 224-pixel image is, across and down."""
    rows, columns = encoded.clip.frames.shape[1:3]
    filled_rows, filled_columns = filled_size(rows, columns)
    return columns / filled_columns, rows / filled_rows
