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
        measures = {part: measure(part.value, belief, frame, recording) for part in COMPONENTS}
        return cls(
            measures,
            right=measure("right", belief, frame, recording).mean,
            down=measure("down", belief, frame, recording).mean,
            moves={part: belief.moves(part) for part in COMPONENTS},
            ways={part: belief.way(part) for part in COMPONENTS},
            limits={part: _limit(part, belief, frame, recording) for part in COMPONENTS},
            readable={part: belief.readable[part] for part in COMPONENTS},
            contact=belief.contact,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values: of each component size, span, limit and whether it moves.

        The spans are of the size, without sign.
        """
        row: dict[str, Any] = {}
        for part in COMPONENTS:
            measured = self.measures[part]
            low, high = measured.span
            row[part.value] = {
                "unit": measured.unit,
                "mean": round(measured.mean, 4),
                "low": low,
                "high": high,
                "limit": self.limits[part],
                "moves": round(self.moves[part], 4),
                "way": self.ways[part].value,
                "readable": self.readable[part],
            }
        row["slide"] |= {"right": round(self.right, 4), "down": round(self.down, 4)}
        return row | {"contact": round(self.contact, 4)}

    def sentence(self) -> str:
        """Return what was measured, and how far off it may be."""
        parts = []
        for part in COMPONENTS:
            way = self.ways[part].value
            doing = {"press": "growth", "release": "shrinking"}.get(way, f"{part.value} {way}")
            what = f"a {doing} of the contact" if part is Component.PRESS else f"a {doing}"
            doubt = "" if self.readable[part] else ", which the picture hardly tells"
            amount = amount_phrase(self.measures[part], with_span=True)
            parts.append(f"{what} of about {amount}{doubt}")
        return f"Measured from the first frame to the last: {'; '.join(parts)}."


def _limit(
    component: Component, belief: Belief, frame: FrameSpec, recording: Recording
) -> float | None:
    if component not in belief.limits:
        return None
    return round(measure(component.value, belief.at_limit, frame, recording).mean, 4)
