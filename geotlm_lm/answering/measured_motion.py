"""What a clip's belief says in the units of its recording: amounts, spans, and what counts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from geotlm_lm.answering.amounts import Measure
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.conversation.felt import Felt
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import travel_scale
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.tolerance import TOLERANCES
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.motion.belief import PX_PER_MM

ASLANT = 1 / 3
"""Share of a slide's greater part from which on the lesser is told with it."""

AXES = {Motion.LEFT: 0, Motion.RIGHT: 0, Motion.UP: 1, Motion.DOWN: 1}
"""The axis of the image that a slide goes along: 0 across, 1 down."""


def felt_of(encoded: Encoded, frame: FrameSpec | None = None) -> Felt:
    """Return what is believed of a clip as decisions read it, named as the camera image shows it.

    Args:
        encoded: The clip.
        frame: Tells the size of a pixel, if anybody does, for the amounts.
    """
    belief, frame = encoded.belief, frame or FrameSpec()
    amounts = {one: measured(encoded, one, frame).amount().phrase for one in COMPONENTS}
    sizes = {one: belief.path(one) for one in COMPONENTS}
    sizes[Component.PRESS] *= PX_PER_MM
    unreadable = frozenset(one for one in COMPONENTS if not belief.readable[one])
    return Felt(belief.ways, belief.contact, sizes, amounts, unreadable, _aslant(encoded))


def measured(
    encoded: Encoded, component: Component, frame: FrameSpec, axis: int | None = None
) -> Measure:
    """Return how far a component goes from the first frame to the last.

    Args:
        encoded: The clip.
        component: Which.
        frame: Tells the size of a pixel, if anybody does; slides are told in pixels otherwise.
        axis: Of a slide: 0 across the recorded image alone, 1 down it; None along its way.
    """
    belief = encoded.belief
    if component is Component.TURN:
        far, deviation = belief.amount(component), belief.deviation(component)
        return Measure(far, deviation, "deg", TOLERANCES["deg"], "turning")
    if component is Component.PRESS:
        doing = "pressing in" if belief.way(component) is Motion.PRESS else "lifting off"
        far, deviation = belief.amount(component), belief.deviation(component)
        return Measure(far, deviation, "mm", TOLERANCES["mm"], doing)
    unit, scale = pixel_scale(encoded, frame)
    way, spread = travel(encoded, frame), scale @ belief.covariance[1:3, 1:3] @ scale
    far = float(np.hypot(*way))
    along = way / far if far > 0 else np.array([1.0, 0.0])
    per_px = far / belief.mean.slide_px if belief.mean.slide_px > 0 else float(scale[0, 0])
    if axis is not None:
        far, along = abs(float(way[axis])), np.eye(2)[axis]
    deviation = math.sqrt(float(along @ spread @ along))
    return Measure(far, deviation, unit, TOLERANCES["px"] * per_px, "sliding")


def travel(encoded: Encoded, frame: FrameSpec) -> np.ndarray:
    """Return the travel right and down, pixels of the recording's frames, or mm."""
    mean = encoded.belief.mean
    return pixel_scale(encoded, frame)[1] @ np.array([mean.right_px, mean.down_px])


@dataclass(frozen=True)
class MeasuredMotion:
    """The motion from the first frame used to the last, as the camera image shows it.

    Args:
        turn: In degrees, clockwise as drawn positive.
        slide: In pixels of the recording's frames, or in mm where their size is known.
        press: In mm, into the gel positive.
        right: Part of the slide to the right, in its unit.
        down: Part of it down the image.
        counts: Probability that each component counts.
        ways: The likeliest way of each, given that it counts.
        readable: Whether the picture tells how far each goes.
        contact: Probability that something touches.
    """

    turn: Measure
    slide: Measure
    press: Measure
    right: float
    down: float
    counts: dict[Component, float]
    ways: dict[Component, Motion]
    readable: dict[Component, bool]
    contact: float

    @classmethod
    def of(cls, encoded: Encoded, frame: FrameSpec) -> MeasuredMotion:
        """Return what is believed of a clip; `frame` tells the size of a pixel, if anybody does."""
        belief, (right, down) = encoded.belief, travel(encoded, frame)
        measures = [measured(encoded, one, frame) for one in COMPONENTS]
        return cls(
            *measures,
            right=float(right),
            down=float(down),
            counts={one: belief.counts(one) for one in COMPONENTS},
            ways={one: belief.way(one) for one in COMPONENTS},
            readable={one: belief.readable[one] for one in COMPONENTS},
            contact=belief.contact,
        )

    def measure(self, component: Component) -> Measure:
        """Return how far a component goes."""
        parts = (self.turn, self.slide, self.press)
        return dict(zip(COMPONENTS, parts, strict=True))[component]

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values: of each component its signed mean, span, and whether it counts.

        The spans are of the size, without sign.
        """
        found: dict[str, Any] = {}
        for one in COMPONENTS:
            measure = self.measure(one)
            told, way = measure.amount(), self.ways[one]
            found[one.value] = {
                "unit": measure.unit,
                "mean": round(measure.mean, 4),
                "low": told.low,
                "high": told.high,
                "counts": round(self.counts[one], 4),
                "way": way.value,
                "readable": self.readable[one],
            }
        found["slide"] |= {"right": round(self.right, 4), "down": round(self.down, 4)}
        return found | {"contact": round(self.contact, 4)}

    def sentence(self) -> str:
        """Return what was measured, and how far off it may be."""
        parts = []
        for one in COMPONENTS:
            told, way = self.measure(one).amount(), self.ways[one].value
            likely = f"likely {told.low:g} to {told.high:g}"
            doing = {"press": "growth", "release": "shrinking"}.get(way, f"{one.value} {way}")
            what = f"a {doing} of the contact" if one is Component.PRESS else f"a {doing}"
            doubt = "" if self.readable[one] else ", which the picture hardly tells"
            parts.append(f"{what} of {told.phrase}, {likely}{doubt}")
        return f"Measured from the first frame to the last: {'; '.join(parts)}."


def pixel_scale(encoded: Encoded, frame: FrameSpec) -> tuple[str, np.ndarray]:
    """Return the unit slides are told in, and what a pixel of ours is of it, across and down."""
    unit, scale = travel_scale(*encoded.clip.frames.shape[1:3], frame.mm_per_px)
    return unit, np.diag(scale)


def _aslant(encoded: Encoded) -> Motion | None:
    """Return the lesser way of a slide that goes between two: across the way that it is told."""
    mean, axis = encoded.belief.mean, AXES[encoded.belief.way(Component.SLIDE)]
    parts = mean.right_px, mean.down_px
    if abs(parts[1 - axis]) <= ASLANT * abs(parts[axis]):
        return None
    ways = ((Motion.LEFT, Motion.RIGHT), (Motion.UP, Motion.DOWN))[1 - axis]
    return ways[int(parts[1 - axis] > 0)]
