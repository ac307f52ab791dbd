"""How far the imprint of a clip moved, in the unit that what is known of the recording allows."""

from __future__ import annotations

import math
from dataclasses import replace

import torch

from geotlm_lm.answering.amounts import Amount, most_probably_right
from geotlm_lm.answering.answer import GOES_BY, Encoded
from geotlm_lm.answering.hearing import Heard
from geotlm_lm.backbone.stem import look
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size, pixel_aspect
from geotlm_lm.evaluation.answers import TOLERANCES
from geotlm_lm.odometry.movement import movement, way_of_slide
from geotlm_lm.odometry.odometer import amounts


def measured(bundle: Bundle, encoded: Encoded, heard: Heard, frame: FrameSpec) -> Amount | None:
    """Return how far it went from the first to the last frame; None where it goes no way.

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
    read, told, scale = heard.slots.unit, heard.slots.unit, 1.0
    inputs, geometry = encoded.perception.inputs, encoded.perception.geometry
    if inputs is None:  # a backbone without the stem
        inputs = torch.from_numpy(look(encoded.clip)[0][None])
    if read == "px":
        told, scale = _slide_scale(encoded, inputs, frame)
    moved = movement(inputs, geometry, pixel_aspect(*encoded.clip.frames.shape[1:3]))
    shares = bundle.odometer.read(moved, read)[0].double().numpy() ** (1 / encoded.doubt)
    weighed = tuple((amounts(read) * scale).tolist())
    amount = most_probably_right(weighed, shares / shares.sum(), told, TOLERANCES[read] * scale)
    return replace(amount, probability=amount.probability * heard.options[GOES_BY[read]])


def _slide_scale(encoded: Encoded, inputs: torch.Tensor, frame: FrameSpec) -> tuple[str, float]:
    """Return the unit slides are told in, and how much of it a pixel of the 224-pixel image is.

    The frames' pixels may be of another size across than down: the way of the slide decides.
    """
    rows, columns = encoded.clip.frames.shape[1:3]
    right, down = way_of_slide(inputs)
    across, along = right * columns / IMAGE_SIDE, down * rows / IMAGE_SIDE
    if frame.mm_per_px is None:
        return "px", math.hypot(across, along)
    # A camera's own pixels are square; those of our square image are wider than high.
    camera_rows, camera_columns = camera_size(rows, columns)
    height = camera_rows / rows * columns / camera_columns
    return "mm", frame.mm_per_px * math.hypot(across, along * height)
