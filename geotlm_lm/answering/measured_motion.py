"""What a clip's belief says in the units of its recording: amounts, spans, limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.amounts import Measure, Recording, measure
from geotlm_lm.query.phrases import amount_phrase


@dataclass(frozen=True)
class MeasuredMotion:
    """The motion from the first frame used to the last, in the frame that the answer is told in.

    Args:
        measures: Of each component how far it goes: degrees, pixels of the recording's frames or mm
            where their size is known, and mm of a press.
        right: Part of the slide to the right, in its unit.
        down: Part of it down the image.
        moves: Probability that each component moves.
        ways: The likeliest way of each, given that it moves.
        limits: How far each has to go to be seen, in the unit of its measure; None where that
            is not known.
        readable: Whether the picture tells how far each goes.
        contact: Probability that something touches.
    """

    measures: dict[Component, Measure]
    right: float
    down: float
    moves: dict[Component, float]
    ways: dict[Component, Motion]
    limits: dict[Component, float | None]
    readable: dict[Component, bool]
    contact: float

    @classmethod
    def of(cls, belief: Belief, recording: Recording, frame: FrameSpec) -> MeasuredMotion:
        """Return what is believed of a clip; `frame` tells the size of a pixel, if anybody does."""
        found = {one: measure(one.value, belief, frame, recording) for one in COMPONENTS}
        return cls(
            found,
            right=measure("right", belief, frame, recording).mean,
            down=measure("down", belief, frame, recording).mean,
            moves={one: belief.moves(one) for one in COMPONENTS},
            ways={one: belief.way(one) for one in COMPONENTS},
            limits={one: _limit(one, belief, frame, recording) for one in COMPONENTS},
            readable={one: belief.readable[one] for one in COMPONENTS},
            contact=belief.contact,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values: of each component size, span, limit and whether it moves.

        The spans are of the size, without sign.
        """
        found: dict[str, Any] = {}
        for one in COMPONENTS:
            told = self.measures[one]
            low, high = told.span
            found[one.value] = {
                "unit": told.unit,
                "mean": round(told.mean, 4),
                "low": low,
                "high": high,
                "limit": self.limits[one],
                "moves": round(self.moves[one], 4),
                "way": self.ways[one].value,
                "readable": self.readable[one],
            }
        found["slide"] |= {"right": round(self.right, 4), "down": round(self.down, 4)}
        return found | {"contact": round(self.contact, 4)}

    def sentence(self) -> str:
        """Return what was measured, and how far off it may be."""
        parts = []
        for one in COMPONENTS:
            way = self.ways[one].value
            doing = {"press": "growth", "release": "shrinking"}.get(way, f"{one.value} {way}")
            what = f"a {doing} of the contact" if one is Component.PRESS else f"a {doing}"
            doubt = "" if self.readable[one] else ", which the picture hardly tells"
            told = amount_phrase(self.measures[one], with_span=True)
            parts.append(f"{what} of about {told}{doubt}")
        return f"Measured from the first frame to the last: {'; '.join(parts)}."


def _limit(
    component: Component, belief: Belief, frame: FrameSpec, recording: Recording
) -> float | None:
    if component not in belief.limits:
        return None
    return round(measure(component.value, belief.at_limit, frame, recording).mean, 4)
