"""How far it slid in x and how far in y, beside how far in all."""

from __future__ import annotations

import math
from dataclasses import replace

from geotlm_lm.answering.amounts import NAMES
from geotlm_lm.answering.answer import Answer, Encoded
from geotlm_lm.answering.measuring import way_in_recording
from geotlm_lm.conversation.wording import clause, sentence
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, along

LEAST_SHARE = 0.5
"""Share of the whole that goes the way told: of less, the two are no parts of one slide."""


def without_components(answer: Answer, way: Motion, frame: FrameSpec) -> Answer:
    """Return the amount of a turn, of which nobody claimed that it slides, with the turn's way."""
    return replace(answer, text=f"It does not slide: {clause(way, frame)}. {answer.text}")


def in_components(encoded: Encoded, answer: Answer, motion: Motion, frame: FrameSpec) -> Answer:
    """Return the amount of a slide with what of it goes right and what goes down, as `frame` tells.

    Where the alignments go another way than the motion told, that way alone is told with it.

    Args:
        encoded: The clip.
        answer: How far, or how fast, it slid in all.
        motion: The slide, in the camera image.
        frame: In which to tell.
    """
    way = frame.tell(motion)
    unit, *rest = answer.amount.unit.split("/")
    right, down = way_in_recording(encoded, unit)

    def part(told: Motion) -> float:
        return along(frame.in_the_image(told), turn=0.0, right=right, down=down)

    text = f"{sentence(way, frame)} {answer.text}"
    if part(way) < LEAST_SHARE:
        return replace(answer, text=text)
    decimals = max(1 - math.floor(math.log10(answer.amount.value)), 0)
    across, downwards = (
        f"{round(answer.amount.value * part(told), decimals) + 0.0:+g}"
        for told in (Motion.RIGHT, Motion.DOWN)
    )
    many = NAMES[unit][1] + " per second" * bool(rest)
    parts = f"{across} in x and {downwards} in y, x to the right and y down, in {many}"
    return replace(answer, text=f"{sentence(way, frame)} About {parts}. {answer.text}")
