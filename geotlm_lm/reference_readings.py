"""Read the motion of a clip by two other methods: the linear probe, and flow with a rigid fit.

Both are shown beside the answer, so that a reader sees whether they agree.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.labels import Motion
from geotlm_lm.probe.rigid_flow import RigidFlow, RigidMotion, classify_motion

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded


@dataclass(frozen=True)
class ReferenceReadings:
    """The motions that two other methods read, among all ten.

    Args:
        probe: The linear probe's choice.
        probe_probability: Its softmax, not calibrated.
        flow: Optical flow's choice.
        moved: The rigid motion that the flow was fitted with.
        timing_ms: Milliseconds of each.
    """

    probe: Motion
    probe_probability: float
    flow: Motion
    moved: RigidMotion
    timing_ms: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "probe": {
                "motion": self.probe.value,
                "probability": round(self.probe_probability, 4),
            },
            "optical_flow": {
                "motion": self.flow.value,
                "rotation_deg": round(self.moved.rotation_deg, 2),
                "slide_x_px": round(self.moved.slide_x_px, 2),
                "slide_y_px": round(self.moved.slide_y_px, 2),
            },
            "timing_ms": {name: round(value, 2) for name, value in self.timing_ms.items()},
        }


def second_opinions(answerer: Answerer, encoded: Encoded) -> ReferenceReadings:
    """Return what the probe and optical flow say of an encoded clip."""
    started = time.perf_counter()
    motions = tuple(Motion)
    probe = answerer.bundle.model.probe
    odds = probe.probabilities(encoded.perception.fused_token, motions)[0].tolist()
    read = time.perf_counter()
    moved = RigidFlow().fit(encoded.clip)
    done = time.perf_counter()
    return ReferenceReadings(
        probe=motions[odds.index(max(odds))],
        probe_probability=max(odds),
        flow=classify_motion(moved, motions),
        moved=moved,
        timing_ms={"probe": 1e3 * (read - started), "optical flow": 1e3 * (done - read)},
    )


def flow_phrase(turn_deg: float, right_px: float, down_px: float) -> str:
    """Return a motion in words without signs: "12.0 degrees clockwise, 3.1 px left"."""
    parts = (
        (turn_deg, "degrees", ("clockwise", "counterclockwise")),
        (right_px, "px", ("right", "left")),
        (down_px, "px", ("down", "up")),
    )
    moving = (part for part in parts if abs(part[0]) >= 0.05)
    texts = [f"{abs(far):.1f} {unit} {ways[int(far < 0)]}" for far, unit, ways in moving]
    return ", ".join(texts) or "nothing moves"
