"""Split a slide's amount into its x and y components."""

from __future__ import annotations

import math
from dataclasses import replace

from geotlm_lm.answering.amounts import NAMES
from geotlm_lm.answering.answer import Answer, Encoded
from geotlm_lm.answering.measured_amounts import slide_direction
from geotlm_lm.conversation.wording import direction_clause, direction_sentence
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, signed_amount

LEAST_SHARE = 0.5
"""Share of the whole that goes the way told: of less, the two are no parts of one slide."""


def without_components(answer: Answer, way: Motion, frame: FrameSpec) -> Answer:
    """Return a turn's amount with its direction; a turn has no x and y components."""
    return replace(answer, text=f"It does not slide: {direction_clause(way, frame)}. {answer.text}")


def split_into_components(
    encoded: Encoded, answer: Answer, motion: Motion, frame: FrameSpec
) -> Answer:
    """Return a slide's amount with its x and y components in `frame`.

    Where the alignments go another way than the motion told, that way alone is told with it.

    Args:
        encoded: The clip.
        answer: How far, or how fast, it slid in all.
        motion: The slide, in the camera image.
        frame: In which to tell.
    """
    way = frame.tell(motion)
    unit, *rest = answer.amount.unit.split("/")
    right, down = slide_direction(encoded, unit)

    def part(told: Motion) -> float:
        return signed_amount(frame.in_the_image(told), turn=0.0, right=right, down=down)

    text = f"{direction_sentence(way, frame)} {answer.text}"
    if part(way) < LEAST_SHARE:
        return replace(answer, text=text)
    decimals = max(1 - math.floor(math.log10(answer.amount.value)), 0)
    across, downwards = (
        f"{round(answer.amount.value * part(told), decimals) + 0.0:+g}"
        for told in (Motion.RIGHT, Motion.DOWN)
    )
    many = NAMES[unit][1] + " per second" * bool(rest)
    parts = f"{across} in x and {downwards} in y, x to the right and y down, in {many}"
    return replace(answer, text=f"{direction_sentence(way, frame)} About {parts}. {answer.text}")
